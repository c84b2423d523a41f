"""Repeats of one cut: how much of the scatter is the process, how much the sensing.

P1 section 12 and table 2. A dynamometer's reading r_i of repeat i is the force of that cut: its
own error is taken as nothing beside the rest. The estimate from the current is e_i = r_i + bias +
s_i. Then

- var(r) is the process' variance;
- var(e − r) is the sensing variance: the paired difference takes the process out, so it is never
  negative and (n − 1) var/σ² is chi-square;
- var(e) − var(r), which P1 prints, has the same mean, but keeps twice the covariance of process and
  sensing error, which is nothing only on average: it scatters more and can be negative. It is what
  is left where only the two variances are known.

Where the reference has an error of its own, var(e − r) holds that too and is an upper bound. A
slope of the estimate over the force other than one counts as sensing error.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.wording import amount_words, localized, phrase, shop_amount, significant

Array = NDArray[np.float64]

LEVEL = 0.05
"""Significance of the tests; P1's."""


@dataclass(frozen=True)
class Sample:
    """Number, mean and variance (n − 1 in the denominator) of repeated values."""

    n: int
    mean: float
    variance: float


@dataclass(frozen=True)
class Variance:
    """A variance with its 95 % interval, in the square of the values' unit."""

    value: float
    low: float
    high: float


@dataclass(frozen=True)
class Comparison:
    """Whether two samples differ, at LEVEL: statistic, degrees of freedom, two-sided p."""

    name: str
    statistic: float
    dof: tuple[float, ...]
    p: float

    @property
    def differ(self) -> bool:
        """Whether the two differ by more than chance allows."""
        return self.p < LEVEL


@dataclass(frozen=True)
class Repeats:
    """What repeats of one cut say. ``by_subtraction``: var(estimate) − var(reference), as P1's."""

    reference: Sample
    estimate: Sample
    process: Variance
    sensing: Variance
    by_subtraction: float
    variances: Comparison
    means: Comparison
    bias: Comparison

    def lines(self, unit: str) -> list[str]:
        """Return it as sentences, for values in ``unit``."""
        scale, _ = shop_amount(1.0, unit)
        shift = self.estimate.mean - self.reference.mean
        return [
            phrase(
                "{count} repeats: reference and estimate {reference} and {estimate} on average",
                count=self.reference.n,
                reference=localized(f"{scale * self.reference.mean:.4g}"),
                estimate=amount_words(self.estimate.mean, unit, ".4g"),
            ),
            phrase(
                "process sd {process}; sensing sd {sensing}",
                process=sd_words(self.process, unit),
                sensing=sd_words(self.sensing, unit),
            ),
            phrase(
                "variances {variances}; means {means}",
                variances=_verdict(self.variances),
                means=_verdict(self.means),
            ),
            phrase(
                "estimate less reference {shift}, in pairs {verdict}",
                shift=amount_words(shift, unit, "+.3g"),
                verdict=_verdict(self.bias),
            ),
        ]


def sd_words(variance: Variance, unit: str) -> str:
    """Say a variance by its standard deviation and the 95 % interval of that, for the reader."""
    scale, name = shop_amount(1.0, unit)
    both = (scale * float(np.sqrt(v)) for v in (variance.value, variance.low, variance.high))
    value, low, high = (localized(significant(one)) for one in both)
    return phrase("{value} {unit} ({low} to {high})", value=value, unit=name, low=low, high=high)


def _verdict(test: Comparison) -> str:
    said = f"{test.name} {localized(f'{test.statistic:.3g}')}, p {localized(f'{test.p:.2g}')}"
    if test.differ:
        return phrase("differ ({test})", test=said)
    return phrase("agree ({test})", test=said)


def sample(values: Array) -> Sample:
    """Return number, mean and variance of repeats (n,); raises ValueError for fewer than two."""
    if len(values) < 2:
        raise ValueError(f"{len(values)} repeats; 2 or more have a variance")
    return Sample(len(values), float(np.mean(values)), float(np.var(values, ddof=1)))


def variance_interval(found: Sample) -> Variance:
    """Return a normal sample's variance with its 95 % chi-square interval."""
    from scipy import stats

    dof = found.n - 1
    low, high = (dof * found.variance / float(stats.chi2.ppf(p, dof)) for p in (0.975, 0.025))
    return Variance(found.variance, low, high)


def equal_variances(a: Sample, b: Sample) -> Comparison:
    """F-test of equal variances, two-sided; F = var(b)/var(a), of independent normal samples."""
    from scipy import stats

    ratio, dof = b.variance / a.variance, (b.n - 1, a.n - 1)
    tail = min(float(stats.f.sf(ratio, *dof)), float(stats.f.cdf(ratio, *dof)))
    return Comparison("F", ratio, (float(dof[0]), float(dof[1])), min(1.0, 2.0 * tail))


def equal_means(a: Sample, b: Sample) -> Comparison:
    """t-test of equal means, two-sided, variances not taken as equal (Welch 1947)."""
    from scipy import stats

    sds = float(np.sqrt(a.variance)), float(np.sqrt(b.variance))
    found = stats.ttest_ind_from_stats(b.mean, sds[1], b.n, a.mean, sds[0], a.n, equal_var=False)
    shares = a.variance / a.n, b.variance / b.n
    dof = sum(shares) ** 2 / (shares[0] ** 2 / (a.n - 1) + shares[1] ** 2 / (b.n - 1))
    return Comparison("t", float(found.statistic), (dof,), float(found.pvalue))


def repeats(reference: Array, estimate: Array) -> Repeats:
    """Return the split of the scatter of repeats (n,) that were sensed both ways.

    The F- and t-test are P1's, of two samples; ``bias`` is the paired t-test, which sees a smaller
    shift because the process is the same in both. Raises ValueError for fewer than two repeats, or
    arrays of different length.
    """
    from scipy import stats

    if len(reference) != len(estimate):
        raise ValueError(f"{len(reference)} references and {len(estimate)} estimates are no pairs")
    own, sensed, difference = sample(reference), sample(estimate), sample(estimate - reference)
    paired = stats.ttest_rel(estimate, reference)
    return Repeats(
        reference=own,
        estimate=sensed,
        process=variance_interval(own),
        sensing=variance_interval(difference),
        by_subtraction=sensed.variance - own.variance,
        variances=equal_variances(own, sensed),
        means=equal_means(own, sensed),
        bias=Comparison("t", float(paired.statistic), (own.n - 1.0,), float(paired.pvalue)),
    )

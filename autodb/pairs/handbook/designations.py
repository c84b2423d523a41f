"""What group of VDI 3323 a material is of by how its name is built, where no list has the name.

Designations say composition or use by themselves: steels by EN 10027-1 (25CrMo4: a low-alloyed
steel; X: a high-alloyed one) and their numbers by EN 10027-2 (1.72xx), metals that are no iron by
DIN 17007-4 and EN 573, SAE J403 and J404 steels by four digits, BS 970 by its series, UNS by its
letter, JIS G 4051 and cast irons by their strength. A name of which the rules say nothing is of no
group.
"""

import re
from collections.abc import Callable
from typing import NamedTuple

Groups = tuple[int, ...]
LOW, TOOL, MILD = (6, 7, 8, 9), (10, 11), (1,)
MIDDLE, HIGH = (2, 3), (4, 5)
FERRITIC, AUSTENITIC = (12, 13), (14,)
WROUGHT_AL, CAST_AL, COPPER = (21, 22), (23, 24), (26, 27, 28)
NICKEL, IRON_BASED, TITANIUM, PURE_TITANIUM = (33, 34), (31, 32), (37,), (36,)

_STEEL_GROUPS: dict[Groups, str] = {
    MILD: "00 01 02 03 04 07 10",
    (1, 2, 3): "11",
    MIDDLE: "05",
    HIGH: "06",
    (2, 3, 4, 5): "12 15 16 17 18",
    (6, 7, 8, 9, 10, 11): "20 21 22 23 24 25 26 27 28",
    TOOL: "32 33",
    FERRITIC: "40 41",
    AUSTENITIC: "43 44 48",
    (12, 13, 14): "45",
    NICKEL: "46",
    (12,): "47",
    IRON_BASED: "49",
}
_OF_NUMBER = {two: groups for groups, text in _STEEL_GROUPS.items() for two in text.split()}
"""VDI groups by the two digits of a steel's number (EN 10027-2, table 1): unalloyed by carbon,
tool steels, high-speed steels, stainless ones by nickel and molybdenum, heat-resistant ones."""
_ELEMENTS = "cr|ni|mo|mn|al|si|ti|nb|cu|v|w|co|pb|te|n|s|b"
LEAST_CR = 10.5
"""Chromium, %, from which a steel is stainless (EN 10088-1)."""
LEAST_NI = 4.5
"""Nickel, %, from which a stainless steel is austenitic or duplex. Chosen: duplex 1.4462 has 5."""


class Told(NamedTuple):
    """Groups that a designation tells, and by what."""

    groups: Groups
    by: str


def groups_by_designation(name: str) -> Told | None:
    """Return the groups that a name tells by how it is built, or None.

    ``name``: in small letters, without blanks and what names the system.
    """
    for pattern, groups, by in _RULES:
        found = pattern.fullmatch(name) or pattern.fullmatch(name.replace("-", ""))
        told = None if found is None else groups(found)
        if told:
            return Told(told, by)
    return None


def _by_carbon(percent: float) -> Groups:
    """Return the groups of an unalloyed steel by its carbon, % (VDI 3323)."""
    return MILD if percent < 0.25 else MIDDLE if percent < 0.55 else HIGH


def _by_number(found: re.Match[str]) -> Groups:
    """Return the groups of 1.WWxx."""
    two = found[1]
    return _OF_NUMBER.get(two, LOW if 50 <= int(two) <= 85 or two == "35" else ())


def _high_alloyed(found: re.Match[str]) -> Groups:
    """Return the groups of X…: stainless by chromium and nickel, else a tool steel.

    Where no dashes stand between the numbers chromium has two digits and nickel two of the rest.
    """
    elements = re.findall(_ELEMENTS, found[2])
    numbers = re.findall(r"[\d.,]+", found[3])
    if len(numbers) == 1 and len(numbers[0]) > 2:
        numbers = [numbers[0][:2], numbers[0][2:4]]
    said = (float(one.replace(",", ".")) for one in numbers)
    percent = dict(zip(elements, said, strict=False))
    chromium, nickel = percent.get("cr", 0.0), percent.get("ni", 0.0)
    cold_work = float(found[1]) > 100.0 and chromium < 16.0  # X210Cr12, not X105CrMo17
    if chromium < LEAST_CR or cold_work:
        return TOOL
    return AUSTENITIC if nickel >= LEAST_NI else FERRITIC


def _unalloyed(found: re.Match[str]) -> Groups:
    hundredths = next(one for one in found.groups() if one)
    return _by_carbon(float(hundredths) / 100.0)


def _sae(found: re.Match[str]) -> Groups:
    """Return the groups of an SAE steel: 10xx to 12xx and 15xx are unalloyed."""
    series, carbon = found[1], float(found[2]) / 100.0
    return _by_carbon(carbon) if series in ("10", "11", "12", "15") else LOW


def _british(found: re.Match[str]) -> Groups:
    """Return the groups of a steel by BS 970: 250 to 299 are of springs, from 500 on alloyed."""
    series, carbon = int(found[1]), float(found[2]) / 100.0
    return _by_carbon(carbon) if series < 250 else LOW if series < 300 or series >= 500 else ()


def _aluminium_alloy(found: re.Match[str]) -> Groups:
    """Return the groups of Al…: cast from 5 % silicon on (EN 1706)."""
    silicon = re.match(r"si(\d+)", found[1])
    percent = float(silicon[1]) if silicon is not None else 0.0
    return (25,) if percent > 12.9 else CAST_AL if percent >= 5.0 else WROUGHT_AL


def _grey(found: re.Match[str]) -> Groups:
    """Return the groups of grey iron by its strength, N/mm² or kp/mm²."""
    strength = float(found[1]) * (10.0 if len(found[1]) < 3 else 1.0)
    return (15,) if strength < 150.0 else (15, 16) if strength < 250.0 else (16,)


def _nodular(found: re.Match[str]) -> Groups:
    """Return the groups of nodular iron by its strength, N/mm² or kp/mm²."""
    strength = float(found[1]) * (10.0 if len(found[1]) < 3 else 1.0)
    return (17,) if strength < 500.0 else (17, 18) if strength < 600.0 else (18,)


def _malleable(found: re.Match[str]) -> Groups:
    """Return the groups of malleable iron by its strength, N/mm² or kp/mm²."""
    strength = float(found[1]) * (10.0 if len(found[1]) < 3 else 1.0)
    return (19,) if strength < 450.0 else (20,)


def _wrought(found: re.Match[str]) -> Groups:
    """Return the groups of wrought aluminium: series 1, 3, 4 and 5 do not harden (EN 573)."""
    return (21,) if found[1] in "1345" else WROUGHT_AL


def _always(groups: Groups) -> Callable[[re.Match[str]], Groups]:
    return lambda _found: groups


_STRENGTH = r"(\d{2,3})(?:\d{1,2})?[a-z]{0,2}"
_EN1, _EN2 = "its designation (EN 10027-1)", "its number (EN 10027-2)"
_DIN, _SAE = "its number (DIN 17007-4)", "its number (SAE J403, J404)"
_BS = "its number (BS 970)"
_UNS, _IRON = "its UNS number", "its strength (EN 1561, EN 1562, EN 1563)"
_AL = "its designation (EN 573, EN 1706)"
_SERIES = "1[0-35]|4[0-8]|5[0-2]|61|8[1-8]|9[2-8]"
_RULES: tuple[tuple[re.Pattern[str], Callable[[re.Match[str]], Groups], str], ...] = tuple(
    (re.compile(pattern), groups, by)
    for pattern, groups, by in (
        (r"1\.(\d\d)\d\d(?:\.\d\d)?", _by_number, _EN2),
        (r"2\.4\d{3}", _always(NICKEL), _DIN),
        (r"2\.[01]\d{3}", _always(COPPER), _DIN),
        (r"3\.[0134]\d{3}", _always(WROUGHT_AL), _DIN),
        (r"3\.70\d\d", _always(PURE_TITANIUM), _DIN),
        (r"3\.7[1-9]\d\d", _always(TITANIUM), _DIN),
        (r"ck?(\d\d)[ersdwugm]?\d?|c(1\d\d)[uw]\d?", _unalloyed, _EN1),
        (r"s(\d\d)ck?", _unalloyed, "its carbon (JIS G 4051)"),
        (r"(\d\d)#", _unalloyed, "its carbon (GB/T 699)"),
        (r"(?:scm|scr|sncm?|smnc?|sacm)\d{3}[a-z]*|suj\d", _always(LOW), "its name (JIS G 4053)"),
        (r"sk[dst]\d{1,3}|skh\d{1,2}", _always(TOOL), "its name (JIS G 4403, G 4404)"),
        (r"sum\d\dl?|ss(?:330|400|490)", _always(MILD), "its name (JIS G 4804, G 3101)"),
        (r"q(?:195|215|235|255|275|345|355)[a-e]?", _always(MILD), "its name (GB/T 700, 1591)"),
        (r"[sep](?:235|275|295|355)\w*", _always(MILD), _EN1),
        (r"(?:st|ust|rst)(?:33|37|44|52)[23]?[ngu]?", _always(MILD), "its strength (DIN 17100)"),
        (r"\d{1,2}s(?:mn)?(?:pb)?\d\d[k+]?", _always(MILD), _EN1),
        (r"g?x(\d{1,3})((?:" + _ELEMENTS + r")+)([-\d.,]*)", _high_alloyed, _EN1),
        (r"(\d{3})[ahm](\d\d)", _british, _BS),
        (r"3\d\ds\d\d", _always(AUSTENITIC), _BS),
        (r"4\d\ds\d\d", _always(FERRITIC), _BS),
        (r"\d{1,3}(?:(?:" + _ELEMENTS + r")[-\d.,]*)+", _always(LOW), _EN1),
        (rf"({_SERIES})[bl]?(\d\d)h?", _sae, _SAE),
        (rf"g({_SERIES})(\d\d)\d", _sae, _UNS),
        (r"s3\d{4}", _always(AUSTENITIC), _UNS),
        (r"s4\d{4}", _always(FERRITIC), _UNS),
        (r"n0[2-9]\d{3}|n1\d{4}", _always(NICKEL), _UNS),
        (r"r50\d{3}", _always(PURE_TITANIUM), _UNS),
        (r"r5[2-8]\d{3}", _always(TITANIUM), _UNS),
        (r"(?:ac)?4[1-8]\d00", _always(CAST_AL), "its number (EN 1706)"),
        (r"(?:al?|aw|alu)([1-8])\d{3}[a-z]?", _wrought, "its series (EN 573)"),
        (
            r"(?:g[kd]?-?)?al((?:cu|zn|mg|mn|si)[\w.,]*)",
            _aluminium_alloy,
            "its designation (EN 573)",
        ),
        (r"c[1-7]\d{3,4}[a-z]?|c[wc]\d{3}[a-z]", _always(COPPER), "its number (UNS, EN 1412)"),
        (r"cu(?:zn|sn|al|ni|pb|be|cr)[\w.,]*", _always(COPPER), "its designation (ISO 1190-1)"),
        (r"(?:ms|rg)\d{1,2}", _always(COPPER), "its name (DIN 17660, DIN 1705)"),
        (r"ni(?:cr|mo|cu|fe)[\w.,]*", _always(NICKEL), "its designation (ISO 9722)"),
        (r"ti(?:al|mo|v|cr)?\d+[a-z][\w.,]*", _always(TITANIUM), "its designation (DIN 17851)"),
        (r"(?:gjl|gg|fc|ht)" + _STRENGTH, _grey, _IRON),
        (r"0\.60(\d\d)", _grey, _IRON),
        (r"(?:gjs|ggg|fcd|qt)" + _STRENGTH, _nodular, _IRON),
        (r"0\.70(\d\d)", _nodular, _IRON),
        (r"(?:gjm[bw]|gt[sw])" + _STRENGTH, _malleable, _IRON),
    )
)
"""How a name is built, whole, what that tells, and the standard that says so."""

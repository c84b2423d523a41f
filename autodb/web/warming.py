"""What pages need once, made while the service begins: who asks first does not wait for it.

Templates are compiled, queries and plots are made once, of any pair that is learnt. It took the
first page of a pair half a second.
"""

import threading
from contextlib import suppress

from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb.agent.answer.coefficients import machine_coefficients
from autodb.agent.answer.force_map import force_map
from autodb.agent.answer.looking_up import PairReader
from autodb.agent.answer.overview import machines_seen
from autodb.agent.learn.precision_history import precision_history
from autodb.agent.learn.usual_cut import usual_cut
from autodb.agent.rows.machines import owner_named
from autodb.reports import figures
from autodb.reports.page import learning_plot
from autodb.reports.pair import force_map_plots
from autodb.store import Store, models
from autodb.web.http import static


def warm_up(store: Store) -> threading.Thread:
    """Begin to make what pages need once, beside all else; return the thread that does."""
    made = threading.Thread(target=_warm, args=(store,), daemon=True)
    made.start()
    return made


def _warm(store: Store) -> None:
    figures.compile_templates()
    for name in static.FILES:
        static.at(name)
    with suppress(Exception), store.reading() as session:  # who asks for it is told what is wrong
        machines_seen(session, most=1)
        _warm_pair(session)


def _warm_pair(session: Session) -> None:
    """Make what the page of a pair shows, of any machine's that is learnt."""
    learnt = select(models.Machine.name).join(
        models.CuttingParameters, models.CuttingParameters.machine_id == models.Machine.id
    )
    machine = session.scalar(learnt.limit(1))
    if machine is None:
        return
    pairs, number = PairReader(session, machine), owner_named(session, machine).id
    for listed in pairs.pairs()[:1]:
        of_pair = listed.material, listed.tool
        basis = pairs.basis(*of_pair)
        cut = usual_cut(session, number, *of_pair)
        basis.look_up(cut)
        curves = precision_history(session, number, listed.material, basis.known.tool, cut)
        for n, curve in enumerate(curves[:1]):
            learning_plot(n, curve)
        force_map_plots(force_map(basis, cut))
        machine_coefficients(session, machine, *of_pair)

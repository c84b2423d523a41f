"""Which commands there are, in the groups of the help, and two examples of each."""

GROUPS = {
    "Start": {
        "demo": "start.demonstrating:demo",
        "init": "start.database:init",
        "machine": "start.database:machine",
        "look": "start.looking:look_command",
        "import": "start.importing:import_",
        "calibrate": "start.calibrating:calibrate_command",
    },
    "Every day": {
        "refresh": "everyday.refreshing:refresh_command",
        "predict": "everyday.predicting:predict_command",
        "lookup": "everyday.looking_up:lookup",
        "predictions": "everyday.scoring:predictions",
        "edge": "everyday.changing_edges:edge",
        "agent": "everyday.running:agent",
        "serve": "everyday.serving:serve",
    },
    "Understand": {
        "explain": "understand.explaining:explain_command",
        "mismatch": "understand.deciding:mismatch",
        "trace": "understand.tracing:trace_command",
        "sensors": "understand.inspecting:sensors_command",
        "identify": "understand.identifying:identify_command",
        "scale": "understand.scaling:scale",
        "reconstruct": "understand.reconstructing:reconstruct_command",
        "inspect": "understand.inspecting:inspect_command",
    },
    "Plan": {
        "plan": "plan.planning:plan_command",
        "life": "plan.lasting:life_command",
        "stability": "plan.stable:stability_command",
        "standard": "plan.standard:standard",
        "sweep": "plan.sweeping:sweep",
    },
    "Maintain": {
        "doctor": "maintain.keeping:doctor",
        "backup": "maintain.keeping:backup_command",
        "restore": "maintain.keeping:restore_command",
        "export": "maintain.keeping:export_command",
        "withdraw": "maintain.taking_back:withdraw_command",
        "schedule": "maintain.scheduling:schedule",
        "fleet": "maintain.fleet:fleet",
        "token": "maintain.tokens:token",
    },
    "Develop": {"prove": "develop.proving:prove"},
}
"""Where each command is, by group and name, in the order of the help: module and name in it."""
COMMANDS = {name: place for commands in GROUPS.values() for name, place in commands.items()}
GROUP_OF = {name: group for group, commands in GROUPS.items() for name in commands}
READERS = frozenset(
    {
        "demo", "init", "machine add", "machine update", "machine rename", "machine retire",
        "machine list", "machine show", "look", "import", "calibrate", "refresh", "predict",
        "lookup", "predictions score", "edge changed", "edge list", "edge undo", "explain",
        "mismatch list", "mismatch show", "mismatch confirm", "mismatch reject", "mismatch reopen",
        "trace", "sensors", "identify", "scale", "reconstruct", "inspect", "plan", "life",
        "stability", "doctor", "fleet refresh", "fleet learn", "fleet show", "predictions match",
        "standard list", "standard show", "standard new", "standard program", "sweep", "backup",
        "restore", "export", "withdraw", "schedule", "token add", "token list", "token revoke",
    }
)  # fmt: skip
"""Commands that answer in the language and the units of their reader."""
EXAMPLES = """
autodb demo
autodb demo --out try-it
autodb init
autodb init --db shop.sqlite3
autodb machine add lathe-1
autodb machine add mill-2 --file mill.toml
autodb machine update lathe-1 --file machine.toml
autodb machine update mill-2 --file mill.toml --db shop.sqlite3
autodb machine rename lathe-1 lathe-hall-2
autodb machine rename mill-2 mill-old --db shop.sqlite3
autodb machine retire lathe-1
autodb machine retire lathe-1 --undo
autodb machine list
autodb machine list --db shop.sqlite3
autodb machine show lathe-1
autodb machine show mill-2 --db shop.sqlite3
autodb look moves.csv
autodb look moves.csv --write
autodb import cuts.csv moves.csv --machine lathe-1
autodb import log.csv --machine lathe-1 --columns columns.toml
autodb calibrate --machine lathe-1
autodb calibrate standard-cuts.csv --protocol turning-aluminium --card card.html
autodb refresh
autodb refresh --machine lathe-1 --inbox recordings --watch
autodb predict job.toml
autodb predict job.toml --machine lathe-1 --plot job.html
autodb lookup
autodb lookup --material C45 --tool CNMG120408 --diameter 50 --depth 2 --feed 0.25 --speed 220
autodb predictions score
autodb predictions score --machine lathe-1 --plot scores.html
autodb predictions match
autodb predictions match --recording 4 --prediction 2 --cut 3=finish
autodb edge changed --tool CNMG120408
autodb edge changed --tool CNMG120408 --machine lathe-1 --at 2026-03-01T07:30 --by Maria
autodb edge list
autodb edge list --machine lathe-1 --all
autodb edge undo 1
autodb edge undo 2 --db shop.sqlite3
autodb agent agent.toml
autodb agent agent.toml --check
autodb serve
autodb serve --port 8400 --write
autodb explain cuts.csv --machine lathe-1
autodb explain measured.csv --simulation simulated.csv --includes inertia,coulomb
autodb mismatch list
autodb mismatch list --machine lathe-1 --all
autodb mismatch show 1
autodb mismatch show 2 --db shop.sqlite3
autodb mismatch confirm 1
autodb mismatch confirm 1 --by Maria --why "the insert was worn"
autodb mismatch reject 1
autodb mismatch reject 1 --why "another bar"
autodb mismatch reopen 1
autodb mismatch reopen 1 --by Maria
autodb trace prediction 1
autodb trace parameters 3
autodb sensors
autodb sensors --machine lathe-1
autodb identify moves.csv --machine lathe-1
autodb identify moves.csv --terms inertia,viscous,coulomb,gravity,cogging --page axis.html
autodb scale push.csv --machine lathe-1
autodb scale loaded.csv --machine lathe-1 --added-mass 40
autodb reconstruct cut.csv --machine lathe-1
autodb reconstruct cut.csv --moves air.csv --page load.html
autodb inspect part.toml
autodb inspect part.toml --machine lathe-1 --recording cuts.csv --cut 3
autodb life job.toml
autodb life rough.toml finish.toml --machine lathe-1 --limit torque.spindle=40 --sure 90
autodb stability job.toml --dynamics tool-point.toml
autodb stability job.toml --dynamics receptance.csv --machine mill-2 --plot lobes.html
autodb plan job.toml
autodb plan job.toml --machine lathe-1 --feed 0.1:0.4 --depth 0.5:3
autodb standard list
autodb standard show turning-aluminium
autodb standard show milling-c45
autodb standard new my-steel repeats.csv
autodb standard new my-steel repeats.csv --like turning-aluminium --out my-steel.toml
autodb standard program turning-aluminium --machine-file machine.toml --dialect fanuc
autodb standard program milling-c45 --machine-file mill.toml --dialect siemens --out cuts.mpf
autodb sweep --machine lathe-1 --axis z --dialect fanuc --park x=150
autodb sweep --machine-file machine.toml --axis x --dialect siemens --minutes 3
autodb doctor
autodb doctor --backups backups
autodb backup copy.sqlite3
autodb backup backups --every day --keep 30
autodb restore copy.sqlite3
autodb restore exported --db shop.sqlite3 --replace
autodb export tables
autodb export --cards cards.csv --machine lathe-1
autodb withdraw 4 --why "wrong material"
autodb withdraw 4 --machine lathe-1 --undo
autodb schedule --inbox recordings
autodb schedule --machine lathe-1 --inbox recordings --every 30 --cron
autodb fleet refresh
autodb fleet refresh --workers 4 --inboxes inboxes
autodb fleet learn
autodb fleet learn --db shop.sqlite3
autodb fleet show
autodb fleet show --db shop.sqlite3
autodb token add planner
autodb token add cell-3 --role operate --days 90
autodb token list
autodb token list --db shop.sqlite3
autodb token revoke planner
autodb token revoke cell-3 --db shop.sqlite3
autodb prove
autodb prove table --out proofs
"""
"""Two examples of every command, which its help and the reference show; a test parses them."""


def example_lines(path: str) -> list[str]:
    """Return the examples of a command, such as `machine add`."""
    words = path.split()
    lines = EXAMPLES.strip().splitlines()
    return [line for line in lines if line.split()[1 : 1 + len(words)] == words]


def examples_of(path: str) -> str:
    """Return what stands below the help of a command."""
    return "\n\n".join(("Examples:", *example_lines(path)))

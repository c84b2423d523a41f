"""Which commands there are, in the groups of the help."""

GROUPS = {
    "Start": {
        "demo": "plan.predict_and_trace:demo",
        "init": "setup.database:init",
        "machine": "setup.database:machine",
        "look": "learn.looking:look_command",
        "import": "learn.importing:import_",
        "calibrate": "learn.calibrating:calibrate_command",
    },
    "Every day": {
        "refresh": "learn.refreshing:refresh_command",
        "predict": "plan.predict_and_trace:predict_command",
        "lookup": "plan.looking_up:lookup",
        "predictions": "plan.scoring:predictions",
        "agent": "learn.running:agent",
        "serve": "setup.serving:serve",
    },
    "Understand": {
        "explain": "understand.explaining:explain_command",
        "mismatch": "understand.deciding:mismatch",
        "trace": "plan.predict_and_trace:trace_command",
        "sensors": "learn.inspecting:sensors_command",
        "identify": "learn.identifying:identify_command",
        "scale": "learn.scaling:scale",
        "reconstruct": "learn.reconstructing:reconstruct_command",
        "inspect": "learn.inspecting:inspect_command",
    },
    "Plan": {
        "plan": "plan.planning:plan_command",
        "stability": "plan.stable:stability_command",
        "standard": "setup.standard:standard",
        "sweep": "setup.sweeping:sweep",
    },
    "Maintain": {
        "doctor": "maintain.keeping:doctor",
        "backup": "maintain.keeping:backup_command",
        "restore": "maintain.keeping:restore_command",
        "export": "maintain.keeping:export_command",
        "withdraw": "maintain.keeping:withdraw_command",
        "schedule": "setup.scheduling:schedule",
        "fleet": "maintain.fleet:fleet",
        "token": "setup.serving:token",
    },
    "Develop": {"prove": "develop.proving:prove"},
}
"""Where each command is, by group and name, in the order of the help: module and name in it."""
COMMANDS = {name: place for commands in GROUPS.values() for name, place in commands.items()}
GROUP_OF = {name: group for group, commands in GROUPS.items() for name in commands}

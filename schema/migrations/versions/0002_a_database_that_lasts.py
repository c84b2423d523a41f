"""Machines as data, estimators, operations, what went on; existing rows are kept as they are."""

from collections.abc import Callable
from typing import Any

import sqlalchemy as sa
from alembic import op

revision = "0002"
down_revision = "0001"
branch_labels = None
depends_on = None

LAW = "linear_edge_nose"
OPERATION = "turn"
"""What 0001 knew: its parameters are of this law and operation."""

OLD_KEY = "uq_cutting_parameters_machine_id"
"""The name that 0001's unnamed key gets while it is dropped, or put back."""

HOLDS_FOR = ("gear_range", "coolant", "spindle_state", "feed_direction")
DIALECTS = ("fanuc", "siemens", "heidenhain", "haas", "mazak", "okuma", "linuxcnc", "other")
COUNTERWEIGHTS = ("none", "weight", "gas", "hydraulic", "spring")
FORMS = ("line", "line-of-speed", "power", "power-of-speed", "line-warmed", "power-warmed",
         "power-of-speed-warmed", "anfis")  # fmt: skip
ESTIMATORS = ("range", "drive", "lstm", "table", "inspection", "fusion")

Kind = Callable[[], sa.types.TypeEngine[Any]]
TEXT, REAL, WHOLE, TRUTH, TREE = sa.String, sa.Double, sa.Integer, sa.Boolean, sa.JSON


def _maybe(kind: Kind, *names: str) -> list[sa.Column[Any]]:
    return [sa.Column(name, kind(), nullable=True) for name in names]


def _needed(kind: Kind, *names: str) -> list[sa.Column[Any]]:
    return [sa.Column(name, kind(), nullable=False) for name in names]


def _id() -> sa.Column[Any]:
    return sa.Column("id", sa.Integer(), primary_key=True, nullable=False)


def _row_of(table: str, *, needed: bool = True) -> sa.Column[Any]:
    key = sa.ForeignKey(f"{table}.id")
    return sa.Column(f"{table}_id", sa.Integer(), key, nullable=not needed, index=True)


def _one_of(column: str, *values: str) -> str:
    listed = ", ".join(f"'{value}'" for value in values)
    return f"{column} IN ({listed})"


def _check(name: str, text: str) -> sa.CheckConstraint:
    return sa.CheckConstraint(text, name=name)


def _unique(name: str, *columns: str) -> sa.UniqueConstraint:
    return sa.UniqueConstraint(*columns, name=name)


def _reference() -> list[sa.Column[Any]]:
    return [*_maybe(REAL, "lower", "upper"), *_maybe(TEXT, "source", "status", "date")]


def _version() -> sa.Column[Any]:
    return sa.Column("version", sa.Integer(), server_default="1", nullable=False)


LINKS = (
    ("calibration", "cut", "calibration_repeat"),
    ("estimator", "recording", "estimator_recording"),
    ("estimator", "calibration", "estimator_source"),
    ("channel_model", "mismatch", "channel_model_mismatch"),
    ("fleet_prior", "cutting_parameters", "fleet_prior_parameters"),
)
CHECKS_OF_0001 = {
    "axis": (
        sa.CheckConstraint("carries IN ('tool', 'work')"),
        sa.CheckConstraint("current_sign IN (-1, 1)"),
    ),
    "recording": (sa.CheckConstraint("kind IN ('cuts', 'series')"),),
    "mismatch": (
        sa.CheckConstraint("status IN ('open', 'confirmed', 'rejected')"),
        sa.CheckConstraint("kind IN ('missing', 'mistuned')"),
    ),
    "sensed_force": (
        sa.CheckConstraint("component IN ('x', 'y', 'z')"),
        sa.CheckConstraint('("value_N" IS NULL) = ("sd_N" IS NULL)'),
    ),
}
"""SQLite changes a table by copying it, and does not carry unnamed checks over by itself."""
CHECKS = {
    "machine": {
        "ck_machine_dialect": _one_of("dialect", *DIALECTS),
        "ck_machine_units": _one_of("units", "mm", "inch"),
    },
    "axis": {
        "ck_axis_counterweight": _one_of("counterweight", *COUNTERWEIGHTS),
        "ck_axis_vertical": _one_of("vertical", "up", "down"),
        "ck_axis_travel": "travel_low_mm < travel_high_mm",
        "ck_axis_torque_constant": (
            '"torque_constant_lower" <= "torque_constant_N_m_A"'
            ' AND "torque_constant_N_m_A" <= "torque_constant_upper"'
        ),
    },
    "tool": {
        "ck_tool_kind": _one_of("kind", "turning_insert", "end_mill", "drill"),
        "ck_tool_teeth": "teeth > 0",
        "ck_tool_diameter": "diameter_mm > 0",
    },
    "recording": {"ck_recording_stored_copy": "(stored_path IS NULL) = (stored_sha256 IS NULL)"},
    "calibration": {
        "ck_calibration_kind": _one_of("kind", *FORMS),
        "ck_calibration_spindle_state": _one_of("spindle_state", "cold", "warm"),
        "ck_calibration_feed_direction": _one_of("feed_direction", "+", "-"),
    },
    "mismatch": {"ck_mismatch_decided": "status <> 'open' OR decided_at IS NULL"},
}
INDICES = {
    "tool": {"ix_tool_kind": ["kind"]},
    "cut": {"ix_cut_pair_operation": ["pair_id", "operation"], "ix_cut_started_at": ["started_at"]},
    "calibration": {"ix_calibration_key": ["machine_id", "axis", *HOLDS_FOR]},
    "sensed_force": {"ix_sensed_force_estimator_id": ["estimator_id"]},
    "mismatch": {"ix_mismatch_status": ["status"]},
}
FOREIGN = {
    "sensed_force": ("fk_sensed_force_estimator", "estimator", "estimator_id"),
    "channel_model": ("fk_channel_model_parent", "channel_model", "parent_id"),
    "cutting_parameters": ("fk_cutting_parameters_prior", "fleet_prior", "prior_id"),
}


def _added() -> dict[str, list[sa.Column[Any]]]:
    """Return the columns that existing tables get."""
    constant = [f"torque_constant_{name}" for name in ("source", "status", "date")]
    return {
        "machine": [
            _version(),
            *_maybe(TEXT, "dialect", "units"),
            *_maybe(TRUTH, "diameter"),
            *_maybe(REAL, "base_speed_rpm", "max_speed_rpm"),
            *_maybe(TREE, "rotary_order"),
        ],
        "axis": [
            *_maybe(TEXT, "carried_by", "vertical", "counterweight", *constant),
            *_maybe(TRUTH, "brake"),
            *_maybe(REAL, "moved_mass_kg", "counterweight_force_N", "rated_A", "screw_pitch_mm"),
            *_maybe(REAL, "gear_ratio", "limit_force_N", "limit_torque_N_m"),
            *_maybe(REAL, "limit_speed_mm_min", "limit_speed_rpm", "travel_low_mm"),
            *_maybe(REAL, "travel_high_mm", "torque_constant_N_m_A", "torque_constant_lower"),
            *_maybe(REAL, "torque_constant_upper"),
        ],
        "tool": [
            *_maybe(TEXT, "kind"),
            *_maybe(WHOLE, "teeth"),
            *_maybe(REAL, "diameter_mm", "helix_deg", "corner_radius_mm", "point_angle_deg"),
        ],
        "recording": [
            *_maybe(TEXT, "stored_path", "stored_sha256"),
            *_maybe(WHOLE, "stored_bytes"),
        ],
        "cut": _maybe(TEXT, "started_at", "state"),
        "calibration": [
            sa.Column("kind", sa.String(), server_default="line", nullable=False),
            *_maybe(TREE, "parameters", "outliers", "trials", "group_covariance"),
            *_maybe(TEXT, *HOLDS_FOR, "protocol"),
            *_maybe(REAL, "cut_sd", "gain_share", "reference_share", "current_sd"),
        ],
        "sensed_force": _maybe(WHOLE, "estimator_id"),
        "channel_model": _maybe(WHOLE, "parent_id"),
        "cutting_parameters": [
            *_maybe(TEXT, "operation", "law", "state", "undone_at"),
            *_maybe(WHOLE, "prior_id"),
        ],
        "mismatch": [
            *_maybe(TREE, "alternatives", "variables", "intervals", "regime"),
            *_maybe(TEXT, "to_tell_apart", "decided_at", "decided_by"),
        ],
    }


def upgrade() -> None:
    _create_tables()
    for name, columns in _added().items():
        with op.batch_alter_table(name, table_args=CHECKS_OF_0001.get(name, ())) as table:
            for column in columns:
                table.add_column(column)
            for check, text in CHECKS.get(name, {}).items():
                table.create_check_constraint(check, sa.text(text))
            for index, of in INDICES.get(name, {}).items():
                table.create_index(index, of)
            if name in FOREIGN:
                key, parent, of_parent = FOREIGN[name]
                table.create_foreign_key(key, parent, [of_parent], ["id"])
            if name == "sensed_force":
                of_version = ["cut_id", "component", "estimator_id"]
                table.create_unique_constraint("uq_sensed_force_estimator", of_version)
    _key_with_operation()


def _key_with_operation() -> None:
    """Give every version its law and operation, and make the operation part of the key."""
    op.execute(f"UPDATE cutting_parameters SET operation = '{OPERATION}', law = '{LAW}'")
    key = ["machine_id", "pair_id", "component", "version"]
    old, convention = _unnamed_key(key)
    with op.batch_alter_table("cutting_parameters", naming_convention=convention) as table:
        table.alter_column("operation", existing_type=sa.String(), nullable=False)
        table.alter_column("law", existing_type=sa.String(), nullable=False)
        table.drop_constraint(old, type_="unique")
        with_operation = ["machine_id", "pair_id", "operation", "component", "version"]
        table.create_unique_constraint("uq_cutting_parameters_key", with_operation)


def _unnamed_key(columns: list[str]) -> tuple[str, dict[str, str]]:
    """Return the name by which 0001's key can be dropped: the server's, or one we make for it."""
    for found in sa.inspect(op.get_bind()).get_unique_constraints("cutting_parameters"):
        if sorted(found["column_names"]) == sorted(columns) and found["name"]:
            return found["name"], {}
    return OLD_KEY, {"uq": "uq_%(table_name)s_%(column_0_name)s"}


def _create_tables() -> None:
    """Make the new tables, each after those that it points to."""
    op.create_table(
        "gear_range",
        *(_id(), _row_of("machine"), *_needed(TEXT, "name"), *_needed(REAL, "low_rpm", "high_rpm")),
        *_maybe(REAL, "base_speed_rpm"),
        _unique("uq_gear_range_machine_name", "machine_id", "name"),
        _check("ck_gear_range_speeds", "low_rpm < high_rpm"),
    )
    op.create_table(
        "tool_property",
        *(_id(), _row_of("tool"), *_needed(TEXT, "code"), *_needed(REAL, "value")),
        *(*_needed(TEXT, "unit"), *_reference()),
        _unique("uq_tool_property_tool_code", "tool_id", "code"),
    )
    op.create_table(
        "conventional_parameter",
        *(_id(), _row_of("material"), *_needed(TEXT, "operation", "component", "name", "unit")),
        *(*_needed(REAL, "value"), *_reference()),
        _unique(
            "uq_conventional_parameter_key",
            *("material_id", "operation", "component", "name", "source"),
        ),
        _check("ck_conventional_parameter_component", _one_of("component", "x", "y", "z")),
        _check("ck_conventional_parameter_bounds", "lower <= value AND value <= upper"),
    )
    op.create_table(
        "recording_channel",
        *(_id(), _row_of("recording"), *_needed(TEXT, "time_base", "name", "unit")),
        *(*_needed(WHOLE, "rows"), *_maybe(REAL, "rate_hz", "minimum", "maximum", "mean", "sd")),
        _unique("uq_recording_channel_key", "recording_id", "time_base", "name"),
        _check("ck_recording_channel_range", "minimum <= maximum"),
        _check("ck_recording_channel_rate", "rate_hz > 0"),
    )
    op.create_index("ix_recording_channel_name", "recording_channel", ["name"])
    op.create_table(
        "estimator",
        *(_id(), _row_of("machine"), *_needed(TEXT, "kind", "component", "since")),
        *(*_needed(WHOLE, "version"), *_maybe(TREE, "model", "normalisation")),
        *(*_maybe(TEXT, "path", "sha256"), *_needed(TREE, "scores")),
        _unique("uq_estimator_key", "machine_id", "kind", "component", "version"),
        _check("ck_estimator_kind", _one_of("kind", *ESTIMATORS)),
        _check("ck_estimator_component", _one_of("component", "x", "y", "z")),
        _check("ck_estimator_file", "(path IS NULL) = (sha256 IS NULL)"),
    )
    op.create_table(
        "sensed_waveform",
        *(_id(), _row_of("recording"), _row_of("estimator")),
        *_needed(TEXT, "component", "path", "sha256", "created_at"),
        *(*_needed(WHOLE, "bytes", "rows"), *_maybe(REAL, "rate_hz", "sd_N")),
        _unique("uq_sensed_waveform_key", "recording_id", "component", "estimator_id"),
        _check("ck_sensed_waveform_component", _one_of("component", "x", "y", "z")),
    )
    op.create_table(
        "fleet_prior",
        *(_id(), _row_of("material"), *_needed(TEXT, "operation", "component", "law")),
        *(*_needed(WHOLE, "version", "machines"), *_needed(TREE, "mean", "covariance")),
        *_needed(TEXT, "created_at"),
        _unique("uq_fleet_prior_key", "material_id", "operation", "component", "law", "version"),
        _check("ck_fleet_prior_component", _one_of("component", "x", "y", "z")),
    )
    op.create_table(
        "refresh_pass",
        *(_id(), _row_of("machine"), *_needed(TEXT, "started_at", "status")),
        *(*_maybe(TEXT, "finished_at"), *_maybe(TREE, "report")),
        *_maybe(WHOLE, "imported", "sensed", "not_sensed", "versions"),
        _check("ck_refresh_pass_status", _one_of("status", "running", "done", "failed")),
        _check("ck_refresh_pass_finished", "(status = 'running') = (finished_at IS NULL)"),
    )
    op.create_index("ix_refresh_pass_machine_started", "refresh_pass", ["machine_id", "started_at"])
    op.create_table(
        "inbox_file",
        *(_id(), _row_of("machine"), *_needed(TEXT, "path", "sha256", "status", "seen_at")),
        *(*_maybe(TEXT, "reason"), _row_of("refresh_pass", needed=False)),
        _row_of("recording", needed=False),
        _unique("uq_inbox_file_key", "machine_id", "path", "sha256"),
        _check("ck_inbox_file_status", _one_of("status", "waiting", "imported", "refused")),
        _check("ck_inbox_file_why", "status <> 'refused' OR reason IS NOT NULL"),
    )
    op.create_index("ix_inbox_file_machine_status", "inbox_file", ["machine_id", "status"])
    op.create_index("ix_inbox_file_sha256", "inbox_file", ["sha256"])
    op.create_table(
        "pair_state",
        *(_id(), _row_of("machine"), _row_of("pair"), *_needed(TEXT, "operation", "updated_at")),
        *(_row_of("refresh_pass", needed=False), _version()),
        _unique("uq_pair_state_key", "machine_id", "pair_id", "operation"),
    )
    op.create_table(
        "access_token",
        *(_id(), *_needed(TEXT, "name", "sha256", "role", "created_at")),
        *_maybe(TEXT, "expires_at", "revoked_at"),
        _unique("uq_access_token_name", "name"),
        _unique("uq_access_token_sha256", "sha256"),
        _check("ck_access_token_role", _one_of("role", "read", "operate", "admin")),
    )
    op.create_table(
        "audit_entry",
        *(_id(), *_needed(TEXT, "at", "who", "action"), _row_of("access_token", needed=False)),
        *(*_maybe(TEXT, "row_kind"), *_maybe(WHOLE, "row_id"), *_maybe(TREE, "detail")),
    )
    op.create_index("ix_audit_entry_at", "audit_entry", ["at"])
    op.create_index("ix_audit_entry_row", "audit_entry", ["row_kind", "row_id"])
    for left, right, name in LINKS:
        key = sa.ForeignKey(f"{left}.id", ondelete="CASCADE")
        op.create_table(
            name,
            sa.Column(f"{left}_id", sa.Integer(), key, primary_key=True, nullable=False),
            sa.Column(
                f"{right}_id", sa.Integer(), sa.ForeignKey(f"{right}.id"),
                primary_key=True, nullable=False, index=True,
            ),
        )  # fmt: skip


def downgrade() -> None:
    _forget_what_0001_cannot_say()
    with op.batch_alter_table("cutting_parameters") as table:
        table.drop_constraint("uq_cutting_parameters_key", type_="unique")
        table.create_unique_constraint(OLD_KEY, ["machine_id", "pair_id", "component", "version"])
    for name, columns in _added().items():
        with op.batch_alter_table(name, table_args=CHECKS_OF_0001.get(name, ())) as table:
            if name == "sensed_force":
                table.drop_constraint("uq_sensed_force_estimator", type_="unique")
            if name in FOREIGN:
                table.drop_constraint(FOREIGN[name][0], type_="foreignkey")
            for index in INDICES.get(name, {}):
                table.drop_index(index)
            for check in CHECKS.get(name, {}):
                table.drop_constraint(check, type_="check")
            for column in columns:
                table.drop_column(column.name)
    for _, _, link in LINKS:
        op.drop_table(link)
    for name in (
        *("audit_entry", "access_token", "pair_state", "inbox_file", "refresh_pass"),
        *("sensed_waveform", "fleet_prior", "estimator", "recording_channel"),
        *("conventional_parameter", "tool_property", "gear_range"),
    ):
        op.drop_table(name)


def _forget_what_0001_cannot_say() -> None:
    """Delete rows that would be read as something else, and all that was derived from them."""
    conditions = " OR ".join(f"{column} IS NOT NULL" for column in (*HOLDS_FOR, "cut_sd"))
    calibrations = f"SELECT id FROM calibration WHERE kind <> 'line' OR {conditions}"
    forces = f"estimator_id IS NOT NULL OR calibration_id IN ({calibrations})"
    parameters = f"""operation <> '{OPERATION}' OR law <> '{LAW}' OR state IS NOT NULL
        OR undone_at IS NOT NULL OR prior_id IS NOT NULL
        OR id IN (SELECT cutting_parameters_id FROM cutting_parameters_force
                  WHERE sensed_force_id IN (SELECT id FROM sensed_force WHERE {forces}))"""
    derived = f"""WITH RECURSIVE gone(id) AS (
        SELECT id FROM cutting_parameters WHERE {parameters}
        UNION SELECT later.id FROM cutting_parameters AS later
              JOIN gone ON later.previous_id = gone.id) SELECT id FROM gone"""
    gone = [row[0] for row in op.get_bind().execute(sa.text(derived))]
    _delete_parameters(gone)
    op.execute(f"DELETE FROM sensed_force WHERE {forces}")
    for link in ("calibration_recording", "calibration_repeat", "estimator_source"):
        op.execute(f"DELETE FROM {link} WHERE calibration_id IN ({calibrations})")
    op.execute(f"DELETE FROM calibration WHERE id IN ({calibrations})")


def _delete_parameters(gone: list[int]) -> None:
    """Delete versions of parameters, newest first, and the predictions made from them."""
    bind = op.get_bind()
    using = "SELECT prediction_id FROM prediction_parameters WHERE cutting_parameters_id = :id"
    found = [bind.execute(sa.text(using), {"id": one}).scalars().all() for one in gone]
    predictions = sorted({prediction for some in found for prediction in some})
    for table, column, ids in (
        ("prediction_parameters", "prediction_id", predictions),
        ("prediction", "id", predictions),
        ("cutting_parameters_force", "cutting_parameters_id", gone),
        ("fleet_prior_parameters", "cutting_parameters_id", gone),
        ("cutting_parameters", "id", sorted(gone, reverse=True)),
    ):
        for one in ids:
            bind.execute(sa.text(f"DELETE FROM {table} WHERE {column} = :id"), {"id": one})

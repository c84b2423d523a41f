"""First tables: machine to mismatch."""

import sqlalchemy as sa
from alembic import op

revision = "0001"
down_revision = None
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "machine",
        sa.Column("id", sa.Integer(), nullable=False),
        sa.Column("name", sa.String(), nullable=False),
        sa.Column("created_at", sa.String(), nullable=False),
        sa.PrimaryKeyConstraint("id"),
        sa.UniqueConstraint("name"),
    )
    op.create_table(
        "material",
        sa.Column("id", sa.Integer(), nullable=False),
        sa.Column("name", sa.String(), nullable=False),
        sa.PrimaryKeyConstraint("id"),
        sa.UniqueConstraint("name"),
    )
    op.create_table(
        "tool",
        sa.Column("id", sa.Integer(), nullable=False),
        sa.Column("name", sa.String(), nullable=False),
        sa.Column("nose_radius_mm", sa.Double(), nullable=True),
        sa.Column("kappa_deg", sa.Double(), nullable=True),
        sa.Column("rake_deg", sa.Double(), nullable=True),
        sa.Column("inclination_deg", sa.Double(), nullable=True),
        sa.PrimaryKeyConstraint("id"),
        sa.UniqueConstraint("name"),
    )
    op.create_table(
        "axis",
        sa.Column("id", sa.Integer(), nullable=False),
        sa.Column("machine_id", sa.Integer(), nullable=False),
        sa.Column("name", sa.String(), nullable=False),
        sa.Column("carries", sa.String(), nullable=False),
        sa.Column("current_sign", sa.Integer(), nullable=False),
        sa.CheckConstraint("carries IN ('tool', 'work')"),
        sa.CheckConstraint("current_sign IN (-1, 1)"),
        sa.ForeignKeyConstraint(
            ["machine_id"],
            ["machine.id"],
        ),
        sa.PrimaryKeyConstraint("id"),
        sa.UniqueConstraint("machine_id", "name"),
    )
    op.create_index(op.f("ix_axis_machine_id"), "axis", ["machine_id"], unique=False)
    op.create_table(
        "calibration",
        sa.Column("id", sa.Integer(), nullable=False),
        sa.Column("machine_id", sa.Integer(), nullable=False),
        sa.Column("axis", sa.String(), nullable=False),
        sa.Column("version", sa.Integer(), nullable=False),
        sa.Column("component", sa.String(), nullable=False),
        sa.Column("channel", sa.String(), nullable=False),
        sa.Column("current_unit", sa.String(), nullable=False),
        sa.Column("unit", sa.String(), nullable=False),
        sa.Column("coefficients", sa.JSON(), nullable=False),
        sa.Column("covariance", sa.JSON(), nullable=False),
        sa.Column("scores", sa.JSON(), nullable=False),
        sa.Column("scores_with_transients", sa.JSON(), nullable=False),
        sa.Column("transients", sa.JSON(), nullable=False),
        sa.Column("current_low", sa.Double(), nullable=False),
        sa.Column("current_high", sa.Double(), nullable=False),
        sa.Column("offered", sa.Boolean(), nullable=False),
        sa.Column("verdict", sa.String(), nullable=False),
        sa.Column("created_at", sa.String(), nullable=False),
        sa.ForeignKeyConstraint(
            ["machine_id"],
            ["machine.id"],
        ),
        sa.PrimaryKeyConstraint("id"),
        sa.UniqueConstraint("machine_id", "axis", "version"),
    )
    op.create_index(op.f("ix_calibration_machine_id"), "calibration", ["machine_id"], unique=False)
    op.create_table(
        "channel_model",
        sa.Column("id", sa.Integer(), nullable=False),
        sa.Column("machine_id", sa.Integer(), nullable=False),
        sa.Column("axis", sa.String(), nullable=False),
        sa.Column("channel", sa.String(), nullable=False),
        sa.Column("version", sa.Integer(), nullable=False),
        sa.Column("unit", sa.String(), nullable=False),
        sa.Column("terms", sa.JSON(), nullable=False),
        sa.Column("covariance", sa.JSON(), nullable=False),
        sa.Column("relative_error", sa.Double(), nullable=False),
        sa.Column("protocol", sa.String(), nullable=False),
        sa.Column("created_at", sa.String(), nullable=False),
        sa.ForeignKeyConstraint(
            ["machine_id"],
            ["machine.id"],
        ),
        sa.PrimaryKeyConstraint("id"),
        sa.UniqueConstraint("machine_id", "channel", "version"),
    )
    op.create_index(
        op.f("ix_channel_model_machine_id"), "channel_model", ["machine_id"], unique=False
    )
    op.create_table(
        "pair",
        sa.Column("id", sa.Integer(), nullable=False),
        sa.Column("material_id", sa.Integer(), nullable=False),
        sa.Column("tool_id", sa.Integer(), nullable=False),
        sa.ForeignKeyConstraint(
            ["material_id"],
            ["material.id"],
        ),
        sa.ForeignKeyConstraint(
            ["tool_id"],
            ["tool.id"],
        ),
        sa.PrimaryKeyConstraint("id"),
        sa.UniqueConstraint("material_id", "tool_id"),
    )
    op.create_table(
        "prediction",
        sa.Column("id", sa.Integer(), nullable=False),
        sa.Column("machine_id", sa.Integer(), nullable=False),
        sa.Column("job", sa.JSON(), nullable=False),
        sa.Column("cuts", sa.JSON(), nullable=False),
        sa.Column("created_at", sa.String(), nullable=False),
        sa.ForeignKeyConstraint(
            ["machine_id"],
            ["machine.id"],
        ),
        sa.PrimaryKeyConstraint("id"),
    )
    op.create_index(op.f("ix_prediction_machine_id"), "prediction", ["machine_id"], unique=False)
    op.create_table(
        "recording",
        sa.Column("id", sa.Integer(), nullable=False),
        sa.Column("machine_id", sa.Integer(), nullable=False),
        sa.Column("sha256", sa.String(), nullable=False),
        sa.Column("path", sa.String(), nullable=False),
        sa.Column("kind", sa.String(), nullable=False),
        sa.Column("rows", sa.Integer(), nullable=False),
        sa.Column("units", sa.JSON(), nullable=False),
        sa.Column("side", sa.JSON(), nullable=False),
        sa.Column("imported_at", sa.String(), nullable=False),
        sa.CheckConstraint("kind IN ('cuts', 'series')"),
        sa.ForeignKeyConstraint(
            ["machine_id"],
            ["machine.id"],
        ),
        sa.PrimaryKeyConstraint("id"),
        sa.UniqueConstraint("machine_id", "sha256"),
    )
    op.create_index(op.f("ix_recording_machine_id"), "recording", ["machine_id"], unique=False)
    op.create_table(
        "calibration_recording",
        sa.Column("calibration_id", sa.Integer(), nullable=False),
        sa.Column("recording_id", sa.Integer(), nullable=False),
        sa.ForeignKeyConstraint(["calibration_id"], ["calibration.id"], ondelete="CASCADE"),
        sa.ForeignKeyConstraint(
            ["recording_id"],
            ["recording.id"],
        ),
        sa.PrimaryKeyConstraint("calibration_id", "recording_id"),
    )
    op.create_index(
        op.f("ix_calibration_recording_recording_id"),
        "calibration_recording",
        ["recording_id"],
        unique=False,
    )
    op.create_table(
        "channel_model_recording",
        sa.Column("channel_model_id", sa.Integer(), nullable=False),
        sa.Column("recording_id", sa.Integer(), nullable=False),
        sa.ForeignKeyConstraint(["channel_model_id"], ["channel_model.id"], ondelete="CASCADE"),
        sa.ForeignKeyConstraint(
            ["recording_id"],
            ["recording.id"],
        ),
        sa.PrimaryKeyConstraint("channel_model_id", "recording_id"),
    )
    op.create_index(
        op.f("ix_channel_model_recording_recording_id"),
        "channel_model_recording",
        ["recording_id"],
        unique=False,
    )
    op.create_table(
        "cut",
        sa.Column("id", sa.Integer(), nullable=False),
        sa.Column("recording_id", sa.Integer(), nullable=False),
        sa.Column("pair_id", sa.Integer(), nullable=True),
        sa.Column("number", sa.Double(), nullable=False),
        sa.Column("operation", sa.String(), nullable=True),
        sa.Column("conditions", sa.JSON(), nullable=False),
        sa.Column("measured", sa.JSON(), nullable=False),
        sa.ForeignKeyConstraint(
            ["pair_id"],
            ["pair.id"],
        ),
        sa.ForeignKeyConstraint(
            ["recording_id"],
            ["recording.id"],
        ),
        sa.PrimaryKeyConstraint("id"),
        sa.UniqueConstraint("recording_id", "number"),
    )
    op.create_index(op.f("ix_cut_pair_id"), "cut", ["pair_id"], unique=False)
    op.create_index(op.f("ix_cut_recording_id"), "cut", ["recording_id"], unique=False)
    op.create_table(
        "cutting_parameters",
        sa.Column("id", sa.Integer(), nullable=False),
        sa.Column("machine_id", sa.Integer(), nullable=False),
        sa.Column("pair_id", sa.Integer(), nullable=False),
        sa.Column("component", sa.String(), nullable=False),
        sa.Column("version", sa.Integer(), nullable=False),
        sa.Column("mean", sa.JSON(), nullable=False),
        sa.Column("covariance", sa.JSON(), nullable=False),
        sa.Column("process_share", sa.Double(), nullable=False),
        sa.Column("misfit_N", sa.Double(), nullable=False),
        sa.Column("n_cuts", sa.Integer(), nullable=False),
        sa.Column("previous_id", sa.Integer(), nullable=True),
        sa.Column("created_at", sa.String(), nullable=False),
        sa.ForeignKeyConstraint(
            ["machine_id"],
            ["machine.id"],
        ),
        sa.ForeignKeyConstraint(
            ["pair_id"],
            ["pair.id"],
        ),
        sa.ForeignKeyConstraint(
            ["previous_id"],
            ["cutting_parameters.id"],
        ),
        sa.PrimaryKeyConstraint("id"),
        sa.UniqueConstraint("machine_id", "pair_id", "component", "version"),
    )
    op.create_index(
        op.f("ix_cutting_parameters_machine_id"), "cutting_parameters", ["machine_id"], unique=False
    )
    op.create_index(
        op.f("ix_cutting_parameters_pair_id"), "cutting_parameters", ["pair_id"], unique=False
    )
    op.create_table(
        "mismatch",
        sa.Column("id", sa.Integer(), nullable=False),
        sa.Column("recording_id", sa.Integer(), nullable=False),
        sa.Column("channel", sa.String(), nullable=False),
        sa.Column("term", sa.String(), nullable=False),
        sa.Column("kind", sa.String(), nullable=False),
        sa.Column("confidence", sa.Double(), nullable=False),
        sa.Column("parameters", sa.JSON(), nullable=False),
        sa.Column("statement", sa.String(), nullable=False),
        sa.Column("status", sa.String(), nullable=False),
        sa.Column("created_at", sa.String(), nullable=False),
        sa.CheckConstraint("kind IN ('missing', 'mistuned')"),
        sa.CheckConstraint("status IN ('open', 'confirmed', 'rejected')"),
        sa.ForeignKeyConstraint(
            ["recording_id"],
            ["recording.id"],
        ),
        sa.PrimaryKeyConstraint("id"),
    )
    op.create_index(op.f("ix_mismatch_recording_id"), "mismatch", ["recording_id"], unique=False)
    op.create_table(
        "prediction_parameters",
        sa.Column("prediction_id", sa.Integer(), nullable=False),
        sa.Column("cutting_parameters_id", sa.Integer(), nullable=False),
        sa.ForeignKeyConstraint(
            ["cutting_parameters_id"],
            ["cutting_parameters.id"],
        ),
        sa.ForeignKeyConstraint(["prediction_id"], ["prediction.id"], ondelete="CASCADE"),
        sa.PrimaryKeyConstraint("prediction_id", "cutting_parameters_id"),
    )
    op.create_index(
        op.f("ix_prediction_parameters_cutting_parameters_id"),
        "prediction_parameters",
        ["cutting_parameters_id"],
        unique=False,
    )
    op.create_table(
        "sensed_force",
        sa.Column("id", sa.Integer(), nullable=False),
        sa.Column("cut_id", sa.Integer(), nullable=False),
        sa.Column("component", sa.String(), nullable=False),
        sa.Column("estimator", sa.String(), nullable=False),
        sa.Column("calibration_id", sa.Integer(), nullable=True),
        sa.Column("value_N", sa.Double(), nullable=True),
        sa.Column("sd_N", sa.Double(), nullable=True),
        sa.Column("common", sa.JSON(), nullable=True),
        sa.Column("reason", sa.String(), nullable=True),
        sa.CheckConstraint("component IN ('x', 'y', 'z')"),
        sa.CheckConstraint(
            '("value_N" IS NULL) = (reason IS NOT NULL)', name="not_sensed_says_why"
        ),
        sa.CheckConstraint('("value_N" IS NULL) = ("sd_N" IS NULL)'),
        sa.ForeignKeyConstraint(
            ["calibration_id"],
            ["calibration.id"],
        ),
        sa.ForeignKeyConstraint(
            ["cut_id"],
            ["cut.id"],
        ),
        sa.PrimaryKeyConstraint("id"),
        sa.UniqueConstraint("cut_id", "component", "estimator", "calibration_id"),
    )
    op.create_index(
        op.f("ix_sensed_force_calibration_id"), "sensed_force", ["calibration_id"], unique=False
    )
    op.create_index(op.f("ix_sensed_force_cut_id"), "sensed_force", ["cut_id"], unique=False)
    op.create_table(
        "cutting_parameters_force",
        sa.Column("cutting_parameters_id", sa.Integer(), nullable=False),
        sa.Column("sensed_force_id", sa.Integer(), nullable=False),
        sa.ForeignKeyConstraint(
            ["cutting_parameters_id"], ["cutting_parameters.id"], ondelete="CASCADE"
        ),
        sa.ForeignKeyConstraint(
            ["sensed_force_id"],
            ["sensed_force.id"],
        ),
        sa.PrimaryKeyConstraint("cutting_parameters_id", "sensed_force_id"),
    )
    op.create_index(
        op.f("ix_cutting_parameters_force_sensed_force_id"),
        "cutting_parameters_force",
        ["sensed_force_id"],
        unique=False,
    )


def downgrade() -> None:
    op.drop_index(
        op.f("ix_cutting_parameters_force_sensed_force_id"), table_name="cutting_parameters_force"
    )
    op.drop_table("cutting_parameters_force")
    op.drop_index(op.f("ix_sensed_force_cut_id"), table_name="sensed_force")
    op.drop_index(op.f("ix_sensed_force_calibration_id"), table_name="sensed_force")
    op.drop_table("sensed_force")
    op.drop_index(
        op.f("ix_prediction_parameters_cutting_parameters_id"), table_name="prediction_parameters"
    )
    op.drop_table("prediction_parameters")
    op.drop_index(op.f("ix_mismatch_recording_id"), table_name="mismatch")
    op.drop_table("mismatch")
    op.drop_index(op.f("ix_cutting_parameters_pair_id"), table_name="cutting_parameters")
    op.drop_index(op.f("ix_cutting_parameters_machine_id"), table_name="cutting_parameters")
    op.drop_table("cutting_parameters")
    op.drop_index(op.f("ix_cut_recording_id"), table_name="cut")
    op.drop_index(op.f("ix_cut_pair_id"), table_name="cut")
    op.drop_table("cut")
    op.drop_index(
        op.f("ix_channel_model_recording_recording_id"), table_name="channel_model_recording"
    )
    op.drop_table("channel_model_recording")
    op.drop_index(op.f("ix_calibration_recording_recording_id"), table_name="calibration_recording")
    op.drop_table("calibration_recording")
    op.drop_index(op.f("ix_recording_machine_id"), table_name="recording")
    op.drop_table("recording")
    op.drop_index(op.f("ix_prediction_machine_id"), table_name="prediction")
    op.drop_table("prediction")
    op.drop_table("pair")
    op.drop_index(op.f("ix_channel_model_machine_id"), table_name="channel_model")
    op.drop_table("channel_model")
    op.drop_index(op.f("ix_calibration_machine_id"), table_name="calibration")
    op.drop_table("calibration")
    op.drop_index(op.f("ix_axis_machine_id"), table_name="axis")
    op.drop_table("axis")
    op.drop_table("tool")
    op.drop_table("material")
    op.drop_table("machine")

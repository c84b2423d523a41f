"""What a machine knows, as tables. Every derived row points to what it came from.

Unknown is NULL. Forces N, lengths mm, speeds as their names say; JSON holds only what is never
searched by. Times are ISO 8601 text in UTC.
"""

from autodb.store.models._base import Base, now, table_of
from autodb.store.models.answers import (
    Mismatch,
    MismatchDecision,
    PredictedCutMade,
    Prediction,
    calibration_mismatch,
    mismatch_pair,
    mismatch_recording,
    prediction_parameters,
)
from autodb.store.models.keeping import AccessToken, AuditEntry, InboxFile, RefreshPass
from autodb.store.models.learning import (
    ChannelModel,
    CuttingParameters,
    FleetPrior,
    channel_model_mismatch,
    channel_model_recording,
    cutting_parameters_force,
    cutting_parameters_mismatch,
    fleet_prior_parameters,
)
from autodb.store.models.machine import Axis, GearRange, Machine
from autodb.store.models.recording import (
    ChangedEdge,
    Cut,
    RecordingChannel,
    StoredRecording,
    counting_cut,
)
from autodb.store.models.sensing import (
    CalibrationVersion,
    DriveScale,
    Estimator,
    SensedForce,
    SensedWaveform,
    calibration_recording,
    calibration_repeat,
    estimator_recording,
    estimator_source,
)
from autodb.store.models.work import (
    ConventionalParameter,
    Material,
    Pair,
    PairState,
    Tool,
    ToolProperty,
)

__all__ = [
    "AccessToken",
    "AuditEntry",
    "Axis",
    "Base",
    "CalibrationVersion",
    "ChangedEdge",
    "ChannelModel",
    "ConventionalParameter",
    "Cut",
    "CuttingParameters",
    "DriveScale",
    "Estimator",
    "FleetPrior",
    "GearRange",
    "InboxFile",
    "Machine",
    "Material",
    "Mismatch",
    "MismatchDecision",
    "Pair",
    "PairState",
    "PredictedCutMade",
    "Prediction",
    "RecordingChannel",
    "RefreshPass",
    "SensedForce",
    "SensedWaveform",
    "StoredRecording",
    "Tool",
    "ToolProperty",
    "calibration_mismatch",
    "calibration_recording",
    "calibration_repeat",
    "channel_model_mismatch",
    "channel_model_recording",
    "counting_cut",
    "cutting_parameters_force",
    "cutting_parameters_mismatch",
    "estimator_recording",
    "estimator_source",
    "fleet_prior_parameters",
    "mismatch_pair",
    "mismatch_recording",
    "now",
    "prediction_parameters",
    "table_of",
]

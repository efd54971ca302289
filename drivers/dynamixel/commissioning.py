"""Who is on the bus, what its EEPROM holds, and what its RAM needs after every start."""

from collections.abc import Sequence

from drivers.dynamixel import control_table as table
from drivers.dynamixel import feedback
from drivers.dynamixel.axis import Axis
from drivers.dynamixel.bus import DynamixelBus, Identity
from drivers.dynamixel.control_table import MODELS, Model
from drivers.dynamixel.errors import WrongModelError, WrongSetupError
from drivers.dynamixel.feedback import ANSWER_EVERYTHING
from drivers.dynamixel.needs import ANSWERS
from drivers.dynamixel.settings import AxisSettings, ServoSettings


def identify(bus: DynamixelBus, axes: Sequence[AxisSettings]) -> list[Model]:
    """Ping every axis and make it answer writes too; raises NoAnswerError, WrongModelError."""
    models = [known_model(bus.port, axis, bus.ping(axis.id)) for axis in axes]
    if len({model.indirect_data_1 for model in models}) > 1:
        raise WrongModelError(
            f"{bus.port}: {', '.join(model.name for model in models)} keep indirect data at different addresses and "
            "cannot be read together; use X430 and X540 models, or X330 models"
        )
    bus.sync_write(table.STATUS_RETURN_LEVEL, dict.fromkeys([axis.id for axis in axes], ANSWER_EVERYTHING))
    return models


def known_model(port: str, axis: AxisSettings, identity: Identity) -> Model:
    """The model of the servo that is to be `axis`; raises WrongModelError for one that the driver cannot use."""
    model = MODELS.get(identity.model_number)
    if model is None:
        raise WrongModelError(
            f"{port}: servo {axis.id} ({axis.name}) has model number {identity.model_number}; known models, which "
            f"measure their current: {', '.join(known.name for known in MODELS.values())}"
        )
    if identity.firmware < model.fast_sync_read_firmware:
        raise WrongModelError(
            f"{port}: servo {axis.id} ({axis.name}), {model.name}, has firmware {identity.firmware}; fast sync read "
            f"needs {model.fast_sync_read_firmware} or newer"
        )
    return model


def check_setup(bus: DynamixelBus, axis: AxisSettings, model: Model) -> None:
    """Compare a servo's EEPROM with what the bench needs; raises WrongSetupError naming the first difference."""
    for register, needed in ANSWERS.items():
        found = bus.read(axis.id, register)
        if found != needed:
            raise WrongSetupError(
                f"{bus.port}: servo {axis.id} ({axis.name}): {register.name} is {found}, needed is {needed}; "
                "`nodal servos setup` writes it"
            )
    limit_ma = bus.read(axis.id, table.CURRENT_LIMIT) * model.current_unit_ma
    if axis.max_current_ma > limit_ma:
        raise WrongSetupError(
            f"{bus.port}: servo {axis.id} ({axis.name}): max_current_ma {axis.max_current_ma:.0f} is above the servo's "
            f"own {table.CURRENT_LIMIT.name} of {limit_ma:.0f} mA; `nodal servos setup` writes it"
        )


def configure(bus: DynamixelBus, axis: Axis, settings: ServoSettings) -> None:
    """Set what a servo's RAM forgets: answers, the feedback block, profile and current bound."""
    servo = axis.settings.id
    bus.sync_write(table.STATUS_RETURN_LEVEL, {servo: ANSWER_EVERYTHING})
    bus.write_bytes(servo, table.INDIRECT_ADDRESS_1, feedback.INDIRECT_ADDRESSES)
    velocity = round(settings.profile_velocity_rad_s / table.RAD_S_PER_VELOCITY)
    acceleration = round(settings.profile_acceleration_rad_s2 / table.RAD_S2_PER_ACCELERATION)
    bus.write(servo, table.PROFILE_ACCELERATION, max(1, acceleration))  # 0 would mean unlimited
    bus.write(servo, table.PROFILE_VELOCITY, max(1, velocity))
    bus.write(servo, table.GOAL_CURRENT, axis.goal_current())

"""The controller inside another program, with that program's own clock, cameras and motors: nothing of the bench runs.

`python docs/examples/embedded_controller.py` homes a toy robot, leads its tip 8 mm aside, and says where it came to stand.
"""

import numpy as np

from controller import (
    Action,
    ActionRequest,
    ActuatorState,
    ControllerSettings,
    Inputs,
    Loop,
    LoopState,
    Outputs,
    Request,
    RobotSettings,
    Sighting,
    State,
    Target,
    sighting_of,
)

PERIOD_S = 0.005
SETTINGS, ROBOT = ControllerSettings(), RobotSettings(section_length_mm=(40.0, 40.0))
NODES, ARC_MM = ("middle", "tip"), np.array([40.0, 80.0])
STAGE_MM = 10.0
HANGS_MM = np.array([0.4, -0.6, 0.0])
GOAL_MM = np.array([8.0, 0.0, STAGE_MM + 79.0])


class Program:
    """Stands for the program that embeds the controller: a robot that is weaker and hangs lower than its model."""

    def __init__(self) -> None:
        self.model = SETTINGS.kinematics(ROBOT)
        self.position_mm = np.append(np.zeros(self.model.axes - 1), STAGE_MM)
        self.zero_mm = np.zeros(self.model.axes)
        self.torque = False
        self.asked: list[Request] = []

    def look(self, cycle: int) -> Sighting | None:
        """What a motion-capture system would say: 40 times a second, at once."""
        if cycle % 5:
            return None
        pulled_mm = (self.position_mm + self.zero_mm) * [*np.full(self.model.axes - 1, 0.8), 1.0]
        node_mm = self.model.nodes_mm(pulled_mm, ARC_MM) + HANGS_MM
        return sighting_of(
            NODES,
            ARC_MM,
            node_mm,
            age_s=0.002,
            standard_deviation_mm=0.05,
            insertion_mm=float(self.position_mm[-1]),
        )

    def report(self) -> ActuatorState:
        """What the motors would say of themselves."""
        axes = len(self.position_mm)
        return ActuatorState(
            displacement_mm=self.position_mm[:-1],
            displacement_mm_s=np.zeros(axes - 1),
            insertion_mm=float(self.position_mm[-1]),
            insertion_mm_s=0.0,
            current_ma=np.full(axes, 100.0),
            temperature_c=np.full(axes, 30.0),
            voltage_v=np.full(axes, 12.0),
            hardware_error=(0,) * axes,
            torque=self.torque,
        )

    def obey(self, outputs: Outputs) -> None:
        """What the motors would do, in the order of the fields."""
        if outputs.release:
            self.torque = False
        if outputs.engage:
            self.torque = True
        if outputs.zero_mm is not None:
            self.zero_mm = self.zero_mm + self.position_mm - outputs.zero_mm
            self.position_mm = outputs.zero_mm
        if outputs.command_mm is not None:
            self.position_mm = self.position_mm + 0.15 * (outputs.command_mm - self.position_mm)

    def ask(self, state: LoopState) -> tuple[Request, ...]:
        """What its user would ask next."""
        asked = len(self.asked)
        if asked == 0:
            self.asked.append(ActionRequest(action=Action.HOME))
        elif asked == 1 and state.mode.state is State.READY:
            goal = Target(
                name="aside",
                node_names=("tip",),
                weights=np.ones(1),
                time_s=np.zeros(1),
                position_mm=GOAL_MM.reshape(1, 1, 3),
                repeat=False,
            )
            self.asked += [goal, ActionRequest(action=Action.ARM)]
        return tuple(self.asked[asked:])


def main() -> None:
    """The ten lines: a clock, a step, and what goes in and comes out of it."""
    program, loop = Program(), Loop(SETTINGS, ROBOT)
    state = loop.start()
    for cycle in range(4000):
        inputs = Inputs(
            now_s=cycle * PERIOD_S,
            dt_s=PERIOD_S,
            sighting=program.look(cycle),
            drive=program.report(),
            absence="",
            requests=program.ask(state),
        )
        state, outputs = loop.step(state, inputs)
        program.obey(outputs)
    assert state.task is not None
    print(f"{state.mode}: the tip stands {state.task.error_mm:.2f} mm from where it was asked to be")


if __name__ == "__main__":
    main()

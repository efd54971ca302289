"""Dynamixel X servos that pull tendon pairs and move the stage.

From bytes to mm: `protocol` (packets, no I/O), `control_table` (registers and models), `port` (the serial device),
`bus` (questions and checked answers), `commissioning` (what a servo must be and be told), `feedback` (the block that is
read each cycle), `axis` (counts and mm), `actuators` (the whole drive).

Another actuator family - other servos, steppers with encoders, a motion controller - takes this one's place by offering
`drivers.actuators.Actuators`, which asks for little: be opened and relaxed in every case; read position, velocity,
current, temperature, voltage and error bits of everything at once; take goals in mm at 200 Hz; be told which mm the
present position is; hold only after `enable`, and stop by itself when nobody speaks to it. It refuses what it must not do
before sending it, ends every call within a bounded time, and raises errors that derive from `ActuatorError`.
"""

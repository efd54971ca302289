"""Dynamixel X servos that pull tendon pairs and move the stage.

From bytes to mm: `protocol` (packets, no I/O), `control_table` (registers and models), `port` (the serial device),
`hearing` (which bytes answer a question), `bus` (questions and checked answers), `needs` (what a servo's EEPROM must hold),
`commissioning` (what a servo must be and be told), `feedback` (the block that is read each cycle), `axis` (counts and mm),
`actuators` (the whole drive). docs/servos.md says what becomes of each fault, docs/actuators.md how another family of
actuators takes this one's place.
"""

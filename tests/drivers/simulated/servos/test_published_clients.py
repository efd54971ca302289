"""Two client libraries written by others talk to the emulated servos: they must find nothing odd about them."""

import dynamixel_sdk as sdk
import numpy as np
import pytest
import rustypot

IDS = [1, 2, 3]
TORQUE, HARDWARE_ERROR, GOAL_POSITION, PRESENT_POSITION, PRESENT_CURRENT = 64, 70, 116, 132, 126
OVERLOAD, ALERT, RANGE_ERROR, ACCESS_ERROR = 0x20, 0x80, 4, 7


@pytest.fixture
def handler():
    return sdk.PacketHandler(2.0)


@pytest.fixture
def port(servos, settings):
    port = sdk.PortHandler(settings.link)
    assert port.openPort()
    assert port.setBaudRate(1_000_000)
    yield port
    port.closePort()


@pytest.fixture
def rusty(servos, settings):
    controller = rustypot.Xl330PyController(settings.link, 1_000_000, 0.5)
    yield controller
    controller.close()


def run(servos, seconds):
    for _ in range(round(seconds / 0.02)):
        servos.step(0.02, np.zeros(3))


def reboot_and_wait(servos, ask):
    """Ask until a rebooted servo answers again; the clients' own time-outs pace the loop."""
    for _ in range(100):
        if ask():
            return
    pytest.fail("the servo did not come back")


class TestDynamixelSdk:
    """ROBOTIS' own library, in Python."""

    def test_ping(self, handler, port):
        assert handler.ping(port, 2) == (1020, sdk.COMM_SUCCESS, 0)
        assert handler.ping(port, 9)[1] == sdk.COMM_RX_TIMEOUT
        found, result = handler.broadcastPing(port)
        assert result == sdk.COMM_SUCCESS
        assert found == {servo: [1020, 48] for servo in IDS}

    def test_read_and_write(self, servos, handler, port):
        assert handler.write4ByteTxRx(port, 1, GOAL_POSITION, 3000) == (sdk.COMM_SUCCESS, 0)
        assert handler.read4ByteTxRx(port, 1, GOAL_POSITION) == (3000, sdk.COMM_SUCCESS, 0)
        assert handler.write1ByteTxRx(port, 1, TORQUE, 1) == (sdk.COMM_SUCCESS, 0)
        run(servos, 3)
        position, result, error = handler.read4ByteTxRx(port, 1, PRESENT_POSITION)
        assert (result, error) == (sdk.COMM_SUCCESS, 0)
        assert position == pytest.approx(3000, abs=5)

    def test_reg_write_and_action(self, handler, port):
        data = [sdk.DXL_LOBYTE(2500), sdk.DXL_HIBYTE(2500), 0, 0]
        assert handler.regWriteTxRx(port, 1, GOAL_POSITION, 4, data) == (sdk.COMM_SUCCESS, 0)
        assert handler.read4ByteTxRx(port, 1, GOAL_POSITION)[0] == 2048
        assert handler.action(port, sdk.BROADCAST_ID) == sdk.COMM_SUCCESS
        assert handler.read4ByteTxRx(port, 1, GOAL_POSITION)[0] == 2500

    def test_errors(self, servos, handler, port):
        assert handler.write1ByteTxRx(port, 1, TORQUE, 7) == (sdk.COMM_SUCCESS, RANGE_ERROR)
        assert handler.write4ByteTxRx(port, 1, PRESENT_POSITION, 7) == (sdk.COMM_SUCCESS, ACCESS_ERROR)
        servos.fail(1, OVERLOAD)
        assert handler.read1ByteTxRx(port, 1, HARDWARE_ERROR) == (OVERLOAD, sdk.COMM_SUCCESS, ALERT)

    def test_reboot(self, servos, handler, port):
        servos.fail(1, OVERLOAD)
        assert handler.reboot(port, 1) == (sdk.COMM_SUCCESS, 0)
        reboot_and_wait(servos, lambda: handler.ping(port, 1)[1] == sdk.COMM_SUCCESS)
        assert handler.read1ByteTxRx(port, 1, HARDWARE_ERROR) == (0, sdk.COMM_SUCCESS, 0)

    @pytest.mark.parametrize("fast", [False, True])
    def test_sync_write_and_sync_read(self, handler, port, fast):
        writer = sdk.GroupSyncWrite(port, handler, GOAL_POSITION, 4)
        reader = sdk.GroupSyncRead(port, handler, GOAL_POSITION, 4)
        for servo in IDS:
            assert writer.addParam(servo, [servo, 8, 0, 0])
            assert reader.addParam(servo)
        assert writer.txPacket() == sdk.COMM_SUCCESS
        assert (reader.fastSyncRead() if fast else reader.txRxPacket()) == sdk.COMM_SUCCESS
        assert [reader.getData(servo, GOAL_POSITION, 4) for servo in IDS] == [2049, 2050, 2051]

    def test_bulk_read(self, handler, port):
        reader = sdk.GroupBulkRead(port, handler)
        assert reader.addParam(1, PRESENT_POSITION, 4)
        assert reader.addParam(3, 146, 1)
        assert reader.txRxPacket() == sdk.COMM_SUCCESS
        assert reader.getData(1, PRESENT_POSITION, 4) == 2048
        assert reader.getData(3, 146, 1) == 28


class TestRustypot:
    """Pollen Robotics' library, in Rust."""

    def test_ping(self, rusty):
        assert [rusty.ping(servo) for servo in IDS] == [True] * 3
        assert not rusty.ping(9)

    def test_read_and_write(self, servos, rusty):
        rusty.write_goal_current(2, 300)
        assert rusty.read_goal_current(2) == [300]
        rusty.write_raw_data(2, GOAL_POSITION, [0, 12, 0, 0])
        rusty.write_torque_enable(2, value=True)
        run(servos, 3)
        raw = bytes(rusty.read_raw_data(2, PRESENT_POSITION, 4))
        assert int.from_bytes(raw, "little") == pytest.approx(3072, abs=5)

    @pytest.mark.parametrize("fast", [False, True])
    def test_sync_write_and_sync_read(self, rusty, fast):
        rusty.set_fast_sync_read(fast)
        rusty.sync_write_goal_current(IDS, [100, -200, 300])
        assert list(rusty.sync_read_goal_current(IDS)) == [100, -200, 300]

    def test_errors(self, servos, rusty):
        servos.fail(3, OVERLOAD)
        value, error = rusty.read_register_with_error(3, "hardware_error_status")
        assert (value, error) == (OVERLOAD, ALERT)

    def test_reboot(self, servos, rusty):
        servos.fail(3, OVERLOAD)
        assert rusty.reboot(3)
        reboot_and_wait(servos, lambda: rusty.ping(3))
        assert rusty.read_register_with_error(3, "hardware_error_status") == (0, 0)

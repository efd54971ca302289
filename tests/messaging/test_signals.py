"""Keys on which the publication itself is the message: anybody may give one, with anything in it."""

import contextlib
import json

import zenoh

from messaging.session import open_rendezvous, open_session
from messaging.topics import STOP


def test_a_signal_counts_whoever_gives_it_and_whatever_it_holds(zenoh_settings, eventually):
    with open_rendezvous(zenoh_settings, "bench"), contextlib.ExitStack() as stack:
        hearing = stack.enter_context(open_session(zenoh_settings, "bench", "controller"))
        giving = stack.enter_context(open_session(zenoh_settings, "bench", "operator"))
        receiver, sender = hearing.hears(STOP), giving.gives(STOP)

        def given(give):
            give()
            return receiver.heard()

        eventually(lambda: given(sender.give))
        while receiver.heard():
            pass
        button_box = zenoh.Config.from_json5(
            json.dumps({"mode": "client", "connect": {"endpoints": [zenoh_settings.rendezvous]}})
        )
        with zenoh.open(button_box) as stranger:
            eventually(lambda: given(lambda: stranger.put("nodal/bench/stop", b"\x00 not a message")))
            eventually(lambda: given(lambda: stranger.delete("nodal/bench/stop")))

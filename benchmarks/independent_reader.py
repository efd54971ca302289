"""Counts a recording's messages with an independent MCAP reader, npm's @mcap/core, and with ours, topic by topic.

    python benchmarks/independent_reader.py LOG.mcap

Needs node and npm; the reader is installed into a temporary folder. Without a recording, a small one is written.
Exit status: 0 the same counts, 1 different ones.
"""

import json
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Iterable
from pathlib import Path

from messaging.topics import TRUTH
from recordings import Log
from recordings.settings import RecorderSettings
from recordings.writer import RecordingWriter

PACKAGE = "@mcap/core@2"
COUNT = """
const fs = require("node:fs");
const { McapIndexedReader } = require("@mcap/core");
async function main(path) {
  const file = await fs.promises.open(path);
  const readable = {
    size: async () => BigInt((await file.stat()).size),
    read: async (offset, length) => {
      const bytes = new Uint8Array(Number(length));
      await file.read(bytes, 0, bytes.length, Number(offset));
      return bytes;
    },
  };
  const reader = await McapIndexedReader.Initialize({ readable });
  const counts = {};
  for await (const message of reader.readMessages()) {
    const { topic } = reader.channelsById.get(message.channelId);
    counts[topic] = (counts[topic] ?? 0) + 1;
  }
  await file.close();
  console.log(JSON.stringify(counts));
}
main(process.argv[2]);
"""


def counted_by_others(files: Iterable[Path]) -> Counter[str]:
    """Messages by topic in all these files; raises CalledProcessError when npm or node fail."""
    counts: Counter[str] = Counter()
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run(
            ["npm", "install", "--no-audit", "--no-fund", "--silent", PACKAGE], cwd=folder, check=True
        )
        script = Path(folder) / "count.js"
        script.write_text(COUNT, encoding="utf-8")
        for file in files:
            answer = subprocess.run(["node", script, file.resolve()], check=True, capture_output=True)
            counts.update(json.loads(answer.stdout))
    return counts


def write_small(path: Path) -> None:
    """A recording of nothing but empty messages on one topic."""
    with RecordingWriter(path, RecorderSettings()) as recording:
        for number in range(1000):
            recording.write(
                TRUTH.key,
                TRUTH.type.protobuf,
                b"",
                sequence=number,
                publish_time_ns=number,
                log_time_ns=number,
            )


def main(words: list[str]) -> int:
    """Print the table."""
    if missing := [tool for tool in ("node", "npm") if shutil.which(tool) is None]:
        print(f"skipped: {' and '.join(missing)} not found")
        return 0
    with tempfile.TemporaryDirectory() as folder:
        recording = Path(words[0]) if words else Path(folder) / "small.mcap"
        if not words:
            write_small(recording)
        log = Log(recording)
        others = counted_by_others(log.parts)
        # file by file, as the others do: Log hands out once what parts repeat of one another
        ours = Counter(entry.stream.topic for file in log.files for entry in file.entries())
    print(f"{recording}\n{'topic':28} {PACKAGE:>14} {'ours':>8}")
    for topic in sorted(others.keys() | ours.keys()):
        print(f"{topic:28} {others[topic]:14} {ours[topic]:8}")
    print(f"{'all':28} {others.total():14} {ours.total():8}")
    return 0 if others == ours else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

"""Read data sets with LeRobot's own package and print what it gives: `python read_lerobot.py FOLDER...`.

LeRobot has its own environment, made by tools/lerobot.mk.
"""

from __future__ import annotations

import json
import os
import sys
from importlib import import_module, metadata
from typing import Any

os.environ["HF_HUB_OFFLINE"] = "1"


def read(folder: str) -> dict[str, Any]:
    """What LeRobot has of a data set: frames as it gives them to policies, and as they are stored."""
    dataset = import_module("lerobot.datasets.lerobot_dataset").LeRobotDataset
    data = dataset("tests/data", root=folder)
    frames = [{key: plain(value) for key, value in data[number].items()} for number in range(len(data))]
    meta = data.meta
    return {
        "frames": frames,
        "types": {key: str(value.dtype) for key, value in data[0].items() if hasattr(value, "dtype")},
        "stored": data.hf_dataset.with_format(None).to_dict(),
        "episodes": [meta.episodes[number] for number in range(meta.total_episodes)],
        "features": meta.features,
        "statistics": {
            key: {name: plain(of) for name, of in each.items()} for key, each in meta.stats.items()
        },
        "fps": meta.fps,
        "active": [find_active(frame) for frame in frames if "language_persistent" in frame],
        "window": read_window(dataset, folder, meta.fps),
        "batch": "language_persistent" in frames[0] or load_batch(data),
    }


def read_window(dataset: Any, folder: str, fps: float) -> list[Any]:
    """The last episode's first frame, with the readings one frame before and after it."""
    last = dataset("tests/data", root=folder).meta.total_episodes - 1
    deltas = {"observation.state": [-1 / fps, 0.0, 1 / fps]}
    item = dataset("tests/data", root=folder, episodes=[last], delta_timestamps=deltas)[0]
    return [plain(item["observation.state"]), plain(item["observation.state_is_pad"])]


def load_batch(data: Any) -> list[int]:
    """The shape of the readings in a batch of all frames."""
    loader = import_module("torch").utils.data.DataLoader(data, batch_size=len(data))
    return list(next(iter(loader))["observation.state"].shape)


def find_active(frame: dict[str, Any]) -> str:
    """The subtask at the time of a frame, as LeRobot's recipes find it."""
    active_at = import_module("lerobot.datasets.language_render").active_at
    found: str = active_at(frame["timestamp"], persistent=frame["language_persistent"], style="subtask")[
        "content"
    ]
    return found


def plain(value: Any) -> Any:
    return value.tolist() if hasattr(value, "tolist") else value


if __name__ == "__main__":
    read_all = {"version": metadata.version("lerobot"), "datasets": [read(folder) for folder in sys.argv[1:]]}
    print(json.dumps(read_all))  # noqa: T201

"""Behavior cloning with PyTorch (Pomerleau 1988): small nets, trained together because each step is small."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from understudy_lab.baselines.inputs import LabeledTicks
from understudy_lab.baselines.sklearn_learners import MlpWeights

HIDDEN = 64


def fit_nets(
    lessons: Sequence[LabeledTicks],
    seed: int,
    *,
    steps: int = 1_000,
    batch: int = 128,
    rate: float = 3e-3,
    decay: float = 1e-2,
) -> list[MlpWeights]:
    """Train a net of two hidden layers for each lesson: AdamW, a cosine schedule (Loshchilov and Hutter 2017, 2019).

    Each net sees only the ticks of its own lesson.
    """
    import torch

    torch.set_num_threads(1)
    draws = torch.Generator().manual_seed(seed)
    places = max(len(lesson.behaviors) for lesson in lessons)
    widths = (max(lesson.x.shape[1] for lesson in lessons), HIDDEN, HIDDEN, places)
    layers = [_layer(torch, len(lessons), *pair, draws) for pair in pairwise(widths)]
    counts = torch.tensor([len(lesson.y) for lesson in lessons])
    first = torch.cumsum(counts, 0) - counts
    every_x = torch.from_numpy(np.concatenate([_padded(lesson.x, widths[0]) for lesson in lessons]))
    every_y = torch.from_numpy(np.concatenate([lesson.y for lesson in lessons]))
    every_weight = torch.from_numpy(np.concatenate([lesson.weight for lesson in lessons]).astype(np.float32))
    closed = torch.stack([torch.arange(places) >= len(lesson.behaviors) for lesson in lessons])
    closed = (closed * -1e9)[:, None, :]
    parameters = [each for layer in layers for each in layer]
    optimizer = torch.optim.AdamW(parameters, lr=rate, weight_decay=decay, fused=True)
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimizer, steps)
    for _ in range(steps):
        drawn = torch.rand((len(lessons), batch), generator=draws)
        rows = ((drawn * counts[:, None]).long() + first[:, None]).flatten()
        x = every_x[rows].view(len(lessons), batch, -1)
        for weights, offset in layers[:-1]:
            x = torch.relu(torch.baddbmm(offset, x, weights))
        weights, offset = layers[-1]
        outputs = (torch.baddbmm(offset, x, weights) + closed).flatten(0, 1)
        losses = torch.nn.functional.cross_entropy(outputs, every_y[rows], reduction="none")
        optimizer.zero_grad()
        ((losses * every_weight[rows]).sum() / batch).backward()
        optimizer.step()
        schedule.step()
    return [_net(layers, k, lesson) for k, lesson in enumerate(lessons)]


def _layer(torch: Any, nets: int, before: int, after: int, draws: Any) -> tuple[Any, Any]:
    """Draw weights [nets, before, after] (He et al. 2015) and offsets [nets, 1, after]."""
    weights = torch.randn((nets, before, after), generator=draws) * (2.0 / before) ** 0.5
    return weights.requires_grad_(), torch.zeros((nets, 1, after), requires_grad=True)


def _padded(x: Any, width: int) -> Any:
    return np.hstack([x, np.zeros((len(x), width - x.shape[1]))]).astype(np.float32)


def _net(layers: Sequence[tuple[Any, Any]], k: int, lesson: LabeledTicks) -> MlpWeights:
    """Return net number k as plain arrays, as wide as its lesson."""
    plain = [[each[k].detach().numpy().astype(np.float64) for each in layer] for layer in layers]
    plain[0][0] = plain[0][0][: lesson.x.shape[1]]
    plain[-1] = [each[:, : len(lesson.behaviors)] for each in plain[-1]]
    return MlpWeights([(weights, offset[0]) for weights, offset in plain])

"""Behavior cloning with PyTorch (Pomerleau 1988): a small net, several of them at once since each step is small."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from understudy.experiments.learners.classical import Layers
from understudy.experiments.learners.inputs import Lesson

HIDDEN = 64


def fit_nets(
    lessons: Sequence[Lesson],
    seed: int,
    *,
    steps: int = 2_000,
    batch: int = 128,
    rate: float = 3e-3,
    decay: float = 1e-2,
    dropout: float = 0.0,
) -> list[Layers]:
    """A net of two hidden layers for each lesson: AdamW, a cosine schedule (Loshchilov and Hutter 2017, 2019).

    The lessons are of one width; each net sees its own ticks only.
    """
    import torch

    torch.set_num_threads(1)
    made = torch.Generator().manual_seed(seed)
    places = max(len(lesson.behaviors) for lesson in lessons)
    widths = (max(lesson.x.shape[1] for lesson in lessons), HIDDEN, HIDDEN, places)
    layers = [_layer(torch, len(lessons), *pair, made) for pair in zip(widths, widths[1:], strict=False)]
    data = [_tensors(torch, lesson, widths[0]) for lesson in lessons]
    closed = torch.stack([torch.arange(places) >= len(lesson.behaviors) for lesson in lessons])[:, None, :]
    parameters = [each for layer in layers for each in layer]
    optimizer = torch.optim.AdamW(parameters, lr=rate, weight_decay=decay)
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimizer, steps)
    for _ in range(steps):
        drawn = [torch.randint(len(y), (batch,), generator=made) for _, y, _ in data]
        x, y, weight = (
            torch.stack([each[part][rows] for each, rows in zip(data, drawn, strict=True)]) for part in range(3)
        )
        for k, (weights, offset) in enumerate(layers):
            x = torch.baddbmm(offset, x, weights)
            if k < len(layers) - 1:
                x = torch.relu(x)
                if dropout:
                    kept = torch.rand(x.shape, generator=made) >= dropout
                    x = x * kept / (1.0 - dropout)
        losses = torch.nn.functional.cross_entropy(
            x.masked_fill(closed, -1e9).flatten(0, 1), y.flatten(), reduction="none"
        )
        loss = (losses * weight.flatten()).sum() / batch
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
        schedule.step()
    return [
        Layers([_plain(weights[k], offset[k], lesson, last=weights is layers[-1][0]) for weights, offset in layers])
        for k, lesson in enumerate(lessons)
    ]


def _layer(torch: Any, nets: int, before: int, after: int, made: Any) -> tuple[Any, Any]:
    """Weights [nets, before, after] (He et al. 2015) and offsets [nets, 1, after]."""
    weights = torch.randn((nets, before, after), generator=made) * (2.0 / before) ** 0.5
    return weights.requires_grad_(), torch.zeros((nets, 1, after), requires_grad=True)


def _tensors(torch: Any, lesson: Lesson, width: int) -> tuple[Any, Any, Any]:
    x = np.zeros((len(lesson.y), width), np.float32)
    x[:, : lesson.x.shape[1]] = lesson.x
    return torch.from_numpy(x), torch.from_numpy(lesson.y), torch.from_numpy(lesson.weight.astype(np.float32))


def _plain(weights: Any, offset: Any, lesson: Lesson, *, last: bool) -> Any:
    found, beside = weights.detach().numpy().astype(np.float64), offset.detach().numpy()[0].astype(np.float64)
    if last:
        return found[:, : len(lesson.behaviors)], beside[: len(lesson.behaviors)]
    return found, beside

"""A kit of a robot that drives ahead or stands by a ball, for runs in every form."""

from understudy import Behavior, Command, Continuous, Feature, Kit, Target

KIT = Kit.from_parts(
    Feature("range", Continuous(), reading="range", of="A"),
    Behavior("ahead", Command(drive=0.5)),
    Behavior("stand", Command(drive=0.0)),
    Target("ball"),
)

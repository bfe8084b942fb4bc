"""What the foraging robot can sense, do and refer to (paper section 4.1): the kit of the foraging world."""

from __future__ import annotations

from understudy.model.behavior import Behavior, Command
from understudy.model.feature import Feature, Flag
from understudy.model.kinds import BOOLEAN, Continuous, Toroidal
from understudy.model.kit import Kit
from understudy.model.target import Target
from understudy.runtime.body import Channel, Reading

READINGS = (
    Reading("range", Continuous(), "m", of_targets=True, doc="How far the target is; absent if none."),
    Reading("bearing", Toroidal(), "rad", of_targets=True, doc="Where it is: 0 ahead, then to the left."),
    Reading("food_here", Continuous(), "units", doc="Food in the nearest source, if within reach."),
    Reading("food_stored", Continuous(), "units", doc="Food the robot carries."),
    Reading("food_left", BOOLEAN, doc="Whether any source still has food."),
    Reading("station_here", BOOLEAN, doc="Whether the station is within reach."),
)

CHANNELS = (
    Channel("drive", unit="forward speeds", doc="1 drives forward, -1 back."),
    Channel("turn", unit="turning speeds", doc="1 turns left, -1 right."),
    Channel("load", doc="Above 0 loads, standing still within reach of food."),
    Channel("unload", doc="Above 0 unloads, standing still within reach of the station."),
)

station = Target("station", "Where food is brought.")
nearest_food = Target("nearest_food", "The nearest source that still has food.")

distance_to = Feature("distance_to", Continuous(), "range", of="A", unit="m", doc="How far A is.")
angle_to = Feature("angle_to", Toroidal(), "bearing", of="A", unit="rad", doc="Where A is: 0 ahead.")
food_below_me = Feature("food_below_me", Continuous(), "food_here", unit="units", doc="Food within reach.")
food_stored = Feature("food_stored", Continuous(), "food_stored", unit="units", doc="Food the robot carries.")
food_left = Feature("food_left", BOOLEAN, "food_left", doc="Whether any food is left to fetch.")
at_station = Feature("at_station", BOOLEAN, "station_here", doc="Whether unloading works here.")
done = Flag("done")

forward = Behavior("forward", Command(drive=1.0), doc="Drive straight ahead.")
rotate_left = Behavior("rotate_left", Command(turn=1.0), doc="Turn left on the spot.")
rotate_right = Behavior("rotate_right", Command(turn=-1.0), doc="Turn right on the spot.")
load_food = Behavior("load_food", Command(load=1.0), doc="Take food from the source within reach.")
unload_food = Behavior("unload_food", Command(unload=1.0), doc="Give food to the station within reach.")

kit = Kit.of(
    distance_to, angle_to, food_below_me, food_stored, food_left, at_station, done,
    forward, rotate_left, rotate_right, load_food, unload_food,
    station, nearest_food,
)  # fmt: skip

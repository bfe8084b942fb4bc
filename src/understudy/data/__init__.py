"""Data of lessons and runs as episodes and data frames, for statistics, figures and other programs."""

from understudy.data.episode import Episode as Episode
from understudy.data.episode import EpisodePress as EpisodePress
from understudy.data.episode_tables import EpisodeFrames as EpisodeFrames
from understudy.data.episode_tables import make_episode_frames as make_episode_frames
from understudy.data.sources import read_episodes as read_episodes
from understudy.data.sources import read_lesson as read_lesson

"""The base task as users of other simulators would write it, each given its best honest chance."""

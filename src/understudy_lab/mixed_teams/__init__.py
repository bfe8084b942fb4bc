"""The experiment with mixed teams: scouts and carriers under one coordinator, which orders and splits them."""

"""Mixed teams: scouts and carriers under one coordinator, which orders both and splits them."""

"""Camera images to color blobs, and their calibration."""

"""Detection of color blobs in camera images, and calibration of the colors."""

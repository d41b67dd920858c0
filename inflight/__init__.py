"""What a satellite's own records show: its orbit, the calibration of its magnetometer and gyro, its inertia."""

"""A boom whose logged joint angles drive its model."""

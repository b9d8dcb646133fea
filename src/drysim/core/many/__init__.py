"""Many: records of one length side by side in the lanes of a vector register."""

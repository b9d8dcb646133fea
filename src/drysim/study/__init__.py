"""What is asked of drysim: cases in, outcomes out. Writes no file and shows nothing."""

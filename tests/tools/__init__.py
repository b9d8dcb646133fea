"""What developers run or borrow beside the tests."""

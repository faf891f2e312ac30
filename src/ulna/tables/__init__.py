"""What people see of an answer: ``..._view`` draws the dictionary that ``answers`` made, so that tables and JSON say the same."""

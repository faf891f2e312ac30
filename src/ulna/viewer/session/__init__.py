"""What a person does with a robot on a page, without the page."""

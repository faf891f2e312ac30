"""What a person does with a robot on a screen, without the screen: any robot, its hand dragged, its world rearranged."""

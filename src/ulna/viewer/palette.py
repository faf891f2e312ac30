"""Colours and opacities of everything drawn. Used by the page, the film and the demo."""

GREEN, RED = (40, 180, 75), (225, 45, 45)
FREE, TOUCHING, MOVABLE, INK = (90, 140, 220), RED, (240, 170, 40), (40, 45, 52)
PALE, STRONG = 0.2, 0.75  # opacities: the arm is seen through its boxes, a touching box is not overlooked

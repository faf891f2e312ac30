"""Shows results in a notebook: ``tables`` as HTML, ``figure`` for curves, ``recording`` for pictures and short films."""

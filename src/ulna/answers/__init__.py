"""Answers as plain data: what ``--json`` prints, and what the tables draw. Metres and radians throughout.

``..._KEYS`` says what the keys mean; ``--help`` shows it.
"""

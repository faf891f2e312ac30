"""The child process that expands a xacro document.

A document is a program. Two things keep it from doing more than computing, each without the other:

1. Its expressions are read as syntax trees, of which few kinds are known, and computed from them (``expressions``). Python's own
   evaluation is never called.
2. The process gives up, before it sees the document, whatever the operating system lets it give up (``confinement``). It opens
   no file: it asks the parent process for each, which decides by ``ulna.description.readable``.

These modules import nothing of Ulna's but each other, so that the process starts fast and holds little.
"""

"""The child process that expands a xacro document.

A document is a program. Two things keep it from doing more than computing, each without the other:

1. Its expressions are read as syntax trees, of which few kinds are known, and computed from them (``expressions``). Python's own
   evaluation is never called.
2. The process gives up, before it sees the document, whatever the operating system lets it give up (``confinement``). It opens
   no file: it asks the parent process for each, which decides by ``ulna.description.readable``.

What each layer is for. The syntax trees stop what a document tries. The others are for a fault of ours in them, by which a
document runs Python: seccomp leaves this Python nothing but computing and the two pipes, on Linux. The limits bound memory and
time everywhere, which seccomp does not, and where there is no seccomp they stop files and sockets from being opened. Landlock is
not used, since it refuses nothing that seccomp allows; nor is an audit hook, which Python can remove.

These modules import nothing of Ulna's but each other, so that the process starts fast and holds little.
"""

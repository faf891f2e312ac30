"""Expands a xacro document in a child process.

A document is a program. Two independent layers prevent it from doing more than computing:

1. Its expressions are parsed to syntax trees, of which few kinds are supported, and computed from them (``expressions``).
   Python's own evaluation is never called.
2. Before it reads the document, the process gives up every right that the operating system lets it give up (``confinement``). It
   opens no file: it asks the parent process for each, which decides by ``ulna.description.readable``.

The syntax trees stop what a document tries. The other layer covers faults in them through which a document could run Python. On
Linux, seccomp leaves that Python only computing and the two pipes. The limits bound memory and time on all systems, which seccomp
does not. Without seccomp they prevent opening files and sockets. Landlock is not used, since it refuses nothing that seccomp
allows; nor is an audit hook, which Python can remove.

These modules import nothing of Ulna's but each other, so that the process starts fast and stays small.
"""

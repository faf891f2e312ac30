"""Decodes video files."""

import av


def decoded(path):
    """The frames of a video as pixels, and what its stream says."""
    with av.open(str(path)) as container:
        stream = container.streams.video[0]
        frames = [frame.to_ndarray(format="rgb24") for frame in container.decode(stream)]
        return (
            frames,
            stream.codec_context.name,
            stream.codec_context.pix_fmt,
            float(stream.average_rate),
            container.duration / 1e6,
        )

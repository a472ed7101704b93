"""Videos for tests."""

import cv2

from facetlog.perception.reading.video_file import VideoFrames


def write_video(path, pictures, code="MJPG"):
    """The path, where the grey pictures are frames of a video now."""
    VideoFrames()  # FFmpeg is made quiet before its first file, or it never is in this process
    height, width = pictures[0].shape
    video = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*code), 10, (width, height), False)
    for picture in pictures:
        video.write(picture)
    video.release()
    return path

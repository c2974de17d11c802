# SPDX-License-Identifier: Apache-2.0
"""Writes a rosbag with the library of ROS: write_bag.py OUT.bag KIND [COMPRESSION] beside raw, 16-bit big-endian frames
of 48 x 40. KIND is a word of main()."""
import struct
import sys

import rosbag
import rospy
from sensor_msgs.msg import CameraInfo, CompressedImage, Image
from std_msgs.msg import Float32, String

WIDTH, HEIGHT = 48, 40


def frames():
    with open("raw", "rb") as raw:
        while True:
            pixels = raw.read(2 * WIDTH * HEIGHT)
            if not pixels:
                return
            yield struct.unpack(">%dH" % (WIDTH * HEIGHT), pixels)


def image(number, values, encoding, code, order="<", padding=0):
    message = Image()
    message.header.seq = number
    message.header.stamp = rospy.Time(50, number * 1000)
    message.header.frame_id = "depth"
    message.width, message.height, message.encoding = WIDTH, HEIGHT, encoding
    message.is_bigendian = 1 if order == ">" else 0
    size = struct.calcsize(code)
    message.step = WIDTH * size + padding
    rows = (values[v * WIDTH:(v + 1) * WIDTH] for v in range(HEIGHT))
    message.data = b"".join(struct.pack("%s%d%s" % (order, WIDTH, code), *row) + bytes(padding) for row in rows)
    return message


def info(distortion=(), model="plumb_bob"):
    message = CameraInfo()
    message.width, message.height, message.distortion_model = WIDTH, HEIGHT, model
    message.D = list(distortion)
    message.K = [43.25, 0, 20.5, 0, 43.5, 21.25, 0, 0, 1]
    message.P = [40, 0, 20, 0, 0, 40, 21, 0, 0, 0, 1, 0]
    return message


def main(out, kind, compression="none"):
    with rosbag.Bag(out, "w", compression=compression, chunk_threshold=6000) as bag:
        def add(topic, message, number=0, seconds=100):
            bag.write(topic, message, rospy.Time(seconds, 33333333 * number))

        add("/note", String("hello"))
        if kind == "realsense" or kind == "units":
            add("/device_0/sensor_0/option/Depth_Units/value", Float32(0.001 if kind == "realsense" else 0.0001))
            add("/device_0/sensor_0/Depth_0/info/camera_info", info([0, 0, 0, 0, 0], "Brown Conrady"))
        for number, values in enumerate(frames()):
            if kind == "realsense" or kind == "units":
                add("/device_0/sensor_0/Depth_0/image/data", image(number, values, "mono16", "H"), number)
                add("/device_0/sensor_1/Color_0/image/data", image(number, values, "mono16", "H"), number)
            elif kind == "ros":
                add("/camera/depth/image_raw", image(number, values, "16UC1", "H", ">", 6), number)
                add("/camera/depth/camera_info", info([0.1, -0.05, 0.001, 0.002, 0.01]), number)
                add("/camera/aligned_depth_to_color/image_raw", image(number, [7] * len(values), "16UC1", "H"), number)
            elif kind == "metres":
                metres = [value / 1000.0 if value else float("nan") for value in values]
                add("/camera/depth/image_rect", image(number, metres, "32FC1", "f"), number)
                add("/camera/depth/camera_info", info([0.1, 0, 0, 0, 0]), number)
            elif kind == "blind":
                add("/camera/depth/image_raw", image(number, values, "16UC1", "H"), number)
            elif kind == "again":
                if number == 3:
                    bag._topic_connections.clear()  # another node writes to the same topics: other connections
                add("/camera/depth/image_raw", image(number, values, "16UC1", "H"), number)
                add("/camera/depth/camera_info", info(), number)
            elif kind == "jump" or kind == "back":
                wrong = {"jump": {2: 4100000}, "back": {2: 40, 3: 40, 4: 40}}[kind]
                add("/camera/depth/image_raw", image(number, values, "16UC1", "H"), number, wrong.get(number, 100))
                add("/camera/depth/camera_info", info(), number)
            elif kind == "two":
                add("/left/depth/image_raw", image(number, values, "16UC1", "H"), number)
                add("/right/depth/image_raw", image(number, values, "16UC1", "H"), number)
            elif kind == "colour":
                add("/camera/color/image_raw", image(number, values, "mono16", "H"), number)
            elif kind == "bytes":
                add("/camera/depth/image_raw", image(number, [value & 255 for value in values], "8UC1", "B"), number)
            elif kind == "packed":
                add("/camera/depth/image_raw/compressedDepth", CompressedImage(), number)
            elif kind == "undone":
                add("/camera/depth/image_rect", image(number, values, "16UC1", "H"), number)
                add("/camera/depth/camera_info", info([0.1, 0, 0, 0], "equidistant"), number)
            elif kind == "fisheye":
                add("/camera/depth/image_raw", image(number, values, "16UC1", "H"), number)
                add("/camera/depth/camera_info", info([0.1, 0, 0, 0], "equidistant"), number)


main(*sys.argv[1:])

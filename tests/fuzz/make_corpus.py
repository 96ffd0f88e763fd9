#!/usr/bin/env python3
"""Writes the tiny files the fuzz targets start from: corpus/READER/NAME, one per feature of a format."""
import pathlib
import struct

HERE = pathlib.Path(__file__).resolve().parent / "corpus"


def write(reader, name, data):
    path = HERE / reader / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(data if isinstance(data, bytes) else data.encode())
    if reader in ("ply", "pcd"):  # what is read in parts as well
        write("cloud_parts", f"{reader}_{name}", data)


def ply(fmt, elements, body=b""):
    return f"ply\nformat {fmt} 1.0\n{elements}end_header\n".encode() + body


XYZ = "property float x\nproperty float y\nproperty float z\n"
FACE = "element face 1\nproperty list uchar int vertex_indices\n"
RGB = "property uchar red\nproperty uchar green\nproperty uchar blue\n"
LITTLE, BIG = "binary_little_endian", "binary_big_endian"

write("ply", "ascii", ply("ascii", f"comment offset 1e6 2 3\nelement vertex 1\n{XYZ}{RGB}", b"1 2 3 4 5 6\n"))
write("ply", "ascii_list", ply("ascii", f"{FACE}element vertex 1\nproperty list uchar int w\n{XYZ}", b"2 0 0\n1 9 1 2 3\n"))
write("ply", "little", ply(LITTLE, f"element vertex 2\n{XYZ}{RGB}", struct.pack("<3f3B3f3B", 1, 2, 3, 4, 5, 6, 1, 2, 3, 4, 5, 6)))
write("ply", "triples", ply(LITTLE, f"element vertex 2\n{XYZ}", struct.pack("<6f", 1, 2, 3, 4, 5, float("nan"))))
write("ply", "big_double", ply(BIG, "comment viewpoint 1 2 3\nelement vertex 1\nproperty double x\nproperty double y\nproperty double z\n"
                               "property float nx\nproperty float ny\nproperty float nz\nproperty ushort intensity\n",
                               struct.pack(">3d3fH", 4e5, 5e6, 100, 0, 0, 1, 7)))
write("ply", "face_first", ply(LITTLE, f"{FACE}element vertex 1\n{XYZ}", struct.pack("<B3i3f", 3, 0, 1, 2, 1, 2, 3)))
write("ply", "map", ply(LITTLE, f"comment offset 1 2 3\nelement vertex 2\n{XYZ}{RGB}property uchar source\nproperty int scan\nproperty int plane\n",
                         struct.pack("<3f4B2i3f4B2i", 1, 2, 3, 4, 5, 6, 0, 7, -1, 1, 2, 3, 4, 5, 6, 1, -1, 8)))
write("ply", "list_inside", ply(LITTLE, f"element vertex 1\nproperty list int double w\n{XYZ}", struct.pack("<id3f", 1, 9, 1, 2, 3)))


def pcd(data, fields="x y z", sizes="4 4 4", types="F F F", counts="1 1 1", n=1):
    return (f"# .PCD v0.7\nVERSION 0.7\nFIELDS {fields}\nSIZE {sizes}\nTYPE {types}\nCOUNT {counts}\nWIDTH {n}\nHEIGHT 1\n"
            f"VIEWPOINT 1 2 3 1 0 0 0\nPOINTS {n}\nDATA {data}\n").encode()


point = struct.pack("<3f", 1, 2, 3)
rich = dict(fields="x y z rgb intensity ring", sizes="4 4 4 4 4 2", types="F F F F F U", counts="1 1 1 1 1 2")
write("pcd", "ascii", pcd("ascii", **rich) + b"1 2 3 1e-39 5 6 7\n")
write("pcd", "binary", pcd("binary", **rich) + point + struct.pack("<IfHH", 0x102030, 5, 6, 7))
write("pcd", "double", pcd("binary", sizes="8 8 8") + struct.pack("<3d", 4e5, 5e6, 100))
write("pcd", "compressed", pcd("binary_compressed") + struct.pack("<II", 13, 12) + b"\x0b" + point)
write("pcd", "compressed_run", pcd("binary_compressed") + struct.pack("<II", 5, 12) + b"\x00\x00\xe0\x02\x00")
write("pcd", "counts", pcd("ascii", fields="ring x y z", sizes="2 4 4 4", types="U F F F", counts="1000000 1 1 1") + b"1 2 3\n")
write("pcd", "offset", b"# offset 1e6 2 3\n" + pcd("ascii") + b"1 2 3\n")

write("cloud_parts", "ply_seven", ply(LITTLE, f"element face 2\nproperty int w\nelement vertex 7\n{XYZ}{RGB}",
                                     struct.pack("<2i", 1, 2) + struct.pack("<3f3B", 1, 2, 3, 4, 5, 6) * 6 + struct.pack("<3f3B", float("inf"), 2, 3, 4, 5, 6)))
write("cloud_parts", "ply_far_lines", ply("ascii", "element vertex 3\n" + XYZ.replace("float", "double"), b"nan 0 0\r\n\n393123.5 5707456.25 112\n393124 5707457 1"))
write("cloud_parts", "pcd_lines", pcd("ascii", n=7) + b"1 2 3\n" * 7)

write("xyz", "plain", "1 2 3\n4 5 6\n")
write("xyz", "names", "x,y,z,intensity,r,g,b\n1,2,3,.5,7,8,9\n")
write("xyz", "semicolons", "\"x\";\"y\";\"z\";name\n1;2;3;\n")
write("xyz", "comment", "# offset 1e6 0 0\n# x y z nx ny nz\n1 2 3 0 0 1\n")
write("xyz", "large", "393123.5 5707456.25 112\n0 0 nan\n")
write("xyz", "pts", "1\n1 2 3 -700 10 20 30\n")

write("dtk_cloud", "header", "100 x 50\nscan\n100 200 300\n-1 2.5e1 +3\n")
write("dtk_cloud", "reflectance", "1 2 3 4\n")

write("trajectory", "tum", "# comment\n1305031102.160407 1 2 3 0 0 0 1\n2,1,2,3,0,0,1,0\n")
write("time_stamps", "rawseeds", "1235603336.0099111\n1235603336.2083869")
write("time_stamps", "csv", "# time, x\n1.5, 2\r\n\n1e9;3\n")
write("trajectory", "kitti", "1 0 0 5 0 1 0 6 0 0 1 7\n")

write("dtk_frames", "two", "1 0 0 0 0 1 0 0 0 0 1 0 9 9 9 1 1\n0 0 -1 0 0 1 0 0 1 0 0 0 100 200 300 1 2\n")
write("dtk_pose", "turned", "100 200 300\n10 -90 1e1\n")

VERTICES = "VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\nVERTEX_SE3:QUAT 1 1 2 3 0 0 1 0\n"
write("g2o", "se3", VERTICES + "FIX 0\nEDGE_SE3:QUAT 0 1 1 2 3 0 0 1 0 " + " ".join("1" * 21) + "\n")
write("g2o", "se2", "VERTEX_SE2 0 1 2 0.5\nEDGE_SE2 0 0 1 2 3 1 0 0 1 0 1\nVERTEX_PLANE 5 1\n")

TURNED = "0 -1 0\n1 0 0\n0 0 1\n1 2 3\n"
write("cameras", "mve", f"drews 1.0\n2 1\n0.7 0 0\n{TURNED}" + "0 0 0\n" * 5 + "7 8 9\n1 2 3\n1 0 5 0\n")
write("cameras", "bundler", f"# Bundle file v0.3\n1 1\n500 0 0\n{TURNED}7 8 9\n1 2 3\n1 0 5 -3.5 2\n")
write("cameras", "colmap", "# c\n2 1 0 0 0 1 2 3 1 b c.jpg\n1.5 2.5 -1\n1 1 0 0 0 0 0 0 9 a.jpg\n\n")
write("cameras", "opensfm", '[{"cameras":{"c":{"focal":0.8}},"shots":{"z":{"rotation":[0,0,1],"translation":[1,2,3],"camera":"c"}},'
                            '"points":{"1":{"coordinates":[1,2,3]}}},{}]')
write("colmap_binary", "cameras", b"c" + struct.pack("<QIiQQ4d", 1, 1, 1, 640, 480, 501, 502, 320, 240))
write("colmap_binary", "images", b"i" + struct.pack("<QI7dI", 1, 2, 1, 0, 0, 0, 1, 2, 3, 1) + b"a.jpg\0" + struct.pack("<QddQ", 1, 1.5, 2.5, 7))
write("colmap_binary", "points", b"p" + struct.pack("<QQ3d3BdQII", 1, 7, 1, 2, 3, 10, 20, 30, 0.5, 1, 1, 2))

write("gps", "by_time", "time,lat,lon,alt\n1000.5,51.4,7.5,149.6\n1001.5,,,\n")
write("gps", "by_image", "\"file\";Longitude;Latitude;height\na.jpg;7.5;-51;3\n")
write("gps", "metric", "# c\nimage x y z\na.jpg 1 2 3\n")
write("gps", "image_times", "time,file\n1000.0,a.jpg\n")
write("gps", "nmea", "$GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,*47\r\n"
                     "$GPRMC,123519,A,4807.038,N,01131.000,E,022.4,084.4,230394,003.1,W*6A\r\n")


def exif():
    """A JPEG of nothing but its EXIF with a GPS directory."""
    rationals = [(2, (46, 50, 33)), (4, (91, 59, 40)), (6, (198,))]
    values, entries = b"", {1: (2, 2, b"N\0\0\0"), 3: (2, 2, b"W\0\0\0"), 5: (1, 1, b"\0\0\0\0")}
    for tag, numbers in rationals:
        entries[tag] = (5, len(numbers), struct.pack("<I", 104 + len(values)))
        values += b"".join(struct.pack("<II", n, 1) for n in numbers)
    gps = struct.pack("<H", 6) + b"".join(struct.pack("<HHI", t, f, n) + v for t, (f, n, v) in sorted(entries.items())) + bytes(4)
    tiff = b"II*\0" + struct.pack("<IHHHII", 8, 1, 0x8825, 4, 1, 26) + bytes(4) + gps + values
    return b"\xff\xd8\xff\xe1" + struct.pack(">H", len(tiff) + 8) + b"Exif\0\0" + tiff + b"\xff\xd9"


write("exif", "position", exif())

#!/usr/bin/env python3
"""Writes the tiny files the fuzz targets start from: corpus/READER/NAME, one per feature of a format."""
import pathlib
import struct

HERE = pathlib.Path(__file__).resolve().parent / "corpus"


def write(reader, name, data):
    path = HERE / reader / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(data if isinstance(data, bytes) else data.encode())


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
write("pcd", "offset", b"# offset 1e6 2 3\n" + pcd("ascii") + b"1 2 3\n")

write("xyz", "plain", "1 2 3\n4 5 6\n")
write("xyz", "names", "x,y,z,intensity,r,g,b\n1,2,3,.5,7,8,9\n")
write("xyz", "semicolons", "\"x\";\"y\";\"z\";name\n1;2;3;\n")
write("xyz", "comment", "# offset 1e6 0 0\n# x y z nx ny nz\n1 2 3 0 0 1\n")
write("xyz", "large", "393123.5 5707456.25 112\n0 0 nan\n")
write("xyz", "pts", "1\n1 2 3 -700 10 20 30\n")

write("dtk_cloud", "header", "100 x 50\nscan\n100 200 300\n-1 2.5e1 +3\n")
write("dtk_cloud", "reflectance", "1 2 3 4\n")

write("trajectory", "tum", "# comment\n1305031102.160407 1 2 3 0 0 0 1\n2,1,2,3,0,0,1,0\n")
write("trajectory", "kitti", "1 0 0 5 0 1 0 6 0 0 1 7\n")

write("dtk_frames", "two", "1 0 0 0 0 1 0 0 0 0 1 0 9 9 9 1 1\n0 0 -1 0 0 1 0 0 1 0 0 0 100 200 300 1 2\n")
write("dtk_pose", "turned", "100 200 300\n10 -90 1e1\n")

VERTICES = "VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\nVERTEX_SE3:QUAT 1 1 2 3 0 0 1 0\n"
write("g2o", "se3", VERTICES + "FIX 0\nEDGE_SE3:QUAT 0 1 1 2 3 0 0 1 0 " + " ".join("1" * 21) + "\n")
write("g2o", "se2", "VERTEX_SE2 0 1 2 0.5\nEDGE_SE2 0 0 1 2 3 1 0 0 1 0 1\nVERTEX_PLANE 5 1\n")

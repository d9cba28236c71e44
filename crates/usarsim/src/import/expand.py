# Expands a xacro file. Arguments: the packages and the folders of modules as JSON, then those of xacro.
# The file is a program, so its memory is bounded here, and its time and output by the caller.
# Python runs isolated (-I), so modules come from its own folders. The user's packages and PYTHONPATH are searched after them.
import json
import site
import sys
import types

site.addsitedir(site.getusersitepackages())
sys.path += json.loads(sys.argv[2])

try:
    import resource

    resource.setrlimit(resource.RLIMIT_AS, (2 << 30, 2 << 30))
except (ImportError, ValueError, OSError):
    pass

try:
    import xacro
except ImportError:
    sys.exit(90)

packages = json.loads(sys.argv[1])


def find(name):
    if name in packages:
        return packages[name]
    print("usarsim: no package " + name, file=sys.stderr)
    # Xacro skips an include whose pattern matches no file.
    return "/[" + name + "]"


# Xacro asks this module for packages. It is a part of ROS 2, and not of PyPI's xacro.
index = types.ModuleType("ament_index_python")
index.packages = types.ModuleType("ament_index_python.packages")
index.packages.get_package_share_directory = find
sys.modules["ament_index_python"] = index
sys.modules["ament_index_python.packages"] = index.packages

# Old files have tags without a prefix, which xacro took until 2018.
OLD = {"property", "include", "macro", "insert_block", "if", "unless"}
OTHERS = {"gazebo", "plugin", "sensor", "transmission", "ros2_control"}
parse = xacro.parse


def parse_old(*arguments, **named):
    document = parse(*arguments, **named)
    nodes = [document.documentElement]
    while nodes:
        node = nodes.pop()
        if node.nodeType == node.ELEMENT_NODE and node.tagName not in OTHERS:
            nameless = node.tagName == "property" and not node.getAttribute("name")
            if node.tagName in OLD and not nameless:
                node.tagName = "xacro:" + node.tagName
            nodes += node.childNodes
    return document


xacro.parse = parse_old

# They call macros without the prefix, too.
URDF = {"robot", "link", "joint", "visual", "collision", "inertial", "geometry", "material", "origin", "axis", "limit"} | OTHERS
call = getattr(xacro, "handle_macro_call", None)


def call_old(node, macros, symbols):
    name = node.tagName
    if ":" not in name and name not in URDF:
        try:
            xacro.resolve_macro(name, macros, symbols)
            node.tagName = "xacro:" + name
        except KeyError:
            pass
    return call(node, macros, symbols)


if call:
    xacro.handle_macro_call = call_old

sys.argv = ["xacro"] + sys.argv[3:]
xacro.main()

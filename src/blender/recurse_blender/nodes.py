"""Shader nodes and their inputs, with node groups, reroutes and muted nodes looked through."""


class Socket:
    """An input of a node: its own name, but link and value of where its value comes from, which may be an input of a
    group around it. `source`: the node and its output that feed it; None where none does. `groups`: the group nodes
    around it, the outermost first."""

    def __init__(self, socket, groups=()):
        self._socket, self.source = socket, None
        self._value = socket
        self._follow(socket, groups)

    def _follow(self, at, groups):
        """Finds the node that feeds the input `at`, or the input that has the value."""
        while at.is_linked and at.links and at.links[0].is_valid and not at.links[0].is_muted:
            node, output = at.links[0].from_node, at.links[0].from_socket
            if node.mute:
                at = next((link.from_socket for link in node.internal_links if link.to_socket == output), None)
            elif node.type == "REROUTE":
                at = node.inputs[0]
            elif node.type == "GROUP" and node.node_tree:
                at, groups = _group_output(node.node_tree, output.identifier), (*groups, node)
            elif node.type == "GROUP_INPUT" and groups:
                at, groups = _with_identifier(groups[-1].inputs, output.identifier), groups[:-1]
            else:
                self.source = Node(node, groups), output
                return
            if at is None:
                return
        if at.node.type != "REROUTE":
            self._value = at

    @property
    def is_linked(self):
        """Whether a node feeds it."""
        return self.source is not None

    @property
    def default_value(self):
        """Its value where no node feeds it."""
        return self._value.default_value if hasattr(self._value, "default_value") else self._socket.default_value

    @property
    def description(self):
        """Its name and its node's, for warnings."""
        return f"'{self._socket.name}' of '{self._socket.node.name}' ({self._socket.node.bl_label})"

    def __getattr__(self, name):
        return getattr(self._socket, name)


def _with_identifier(sockets, identifier):
    return next((socket for socket in sockets if socket.identifier == identifier), None)


def _group_output(tree, identifier):
    """The input of the group's output node."""
    for node in tree.nodes:
        if node.type == "GROUP_OUTPUT" and node.is_active_output:
            return _with_identifier(node.inputs, identifier)
    return None


class Inputs:
    """The inputs of a node, by name or number."""

    def __init__(self, inputs, groups):
        self._inputs, self._groups = inputs, groups

    def __getitem__(self, key):
        return Socket(self._inputs[key], self._groups)

    def __contains__(self, name):
        return name in self._inputs

    def __iter__(self):
        return (Socket(socket, self._groups) for socket in self._inputs)

    def get(self, name):
        """None where there is none of that name."""
        return self[name] if name in self._inputs else None


class Node:
    """A node inside of `groups`: a node of Blender but for its inputs."""

    def __init__(self, node, groups=()):
        self._node = node
        self.inputs = Inputs(node.inputs, groups)

    def __getattr__(self, name):
        return getattr(self._node, name)


def output_node(tree):
    """The output of a material, lamp or world; None where it has none."""
    node = tree.get_output_node("CYCLES") or tree.get_output_node("ALL")
    return Node(node) if node else None

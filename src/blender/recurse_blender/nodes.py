"""Shader nodes and their inputs, with node groups, reroutes and muted nodes resolved."""


class Socket:
    """Input of a node, with its own name, but with the link and value of the place where its value is set, which may be
    an input of an enclosing group. `source`: the node and its output that feed it, or None. `groups`: the enclosing
    group nodes, the outermost first."""

    def __init__(self, socket, groups=()):
        self._socket, self.source = socket, None
        self._value = socket
        self._follow(socket, groups)

    def _follow(self, at, groups):
        """Finds the node that feeds the input `at`, or the input with its value."""
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
        """Whether a node feeds the input."""
        return self.source is not None

    @property
    def default_value(self):
        """Value of the input if no node feeds it."""
        return self._value.default_value if hasattr(self._value, "default_value") else self._socket.default_value

    @property
    def description(self):
        """Names of the input and its node, for warnings."""
        return f"'{self._socket.name}' of '{self._socket.node.name}' ({self._socket.node.bl_label})"

    def __getattr__(self, name):
        return getattr(self._socket, name)


def _with_identifier(sockets, identifier):
    return next((socket for socket in sockets if socket.identifier == identifier), None)


def _group_output(tree, identifier):
    """Input of the group's output node; None if there is none."""
    for node in tree.nodes:
        if node.type == "GROUP_OUTPUT" and node.is_active_output:
            return _with_identifier(node.inputs, identifier)
    return None


class Inputs:
    """Inputs of a node, by name or number."""

    def __init__(self, inputs, groups):
        self._inputs, self._groups = inputs, groups

    def __getitem__(self, key):
        return Socket(self._inputs[key], self._groups)

    def __contains__(self, name):
        return name in self._inputs

    def __iter__(self):
        return (Socket(socket, self._groups) for socket in self._inputs)

    def get(self, name):
        """Input of that name, or None."""
        return self[name] if name in self._inputs else None


class Node:
    """Node inside of `groups`: acts as Blender's node, except for its inputs."""

    def __init__(self, node, groups=()):
        self._node = node
        self.inputs = Inputs(node.inputs, groups)

    def __getattr__(self, name):
        return getattr(self._node, name)


def output_node(tree):
    """Output node of a material, lamp or world, or None."""
    node = tree.get_output_node("CYCLES") or tree.get_output_node("ALL")
    return Node(node) if node else None

"""Of a Nastran deck: the frequencies that Nastran printed for it, and a copy with Nastran's lumped masses.

.op2 files and lumped copies need pyNastran (pip install pyNastran).
"""

import collections
import math
import os
import re
import subprocess
import tempfile

import h5py
import numpy as np
import scipy.linalg

try:
    from pyNastran.bdf.bdf import BDF
    from pyNastran.op2.op2 import OP2
except ImportError:
    BDF = OP2 = None


ELASTIC = 1e-6  # of the highest frequency: what lies below are rigid motions


def results_beside(deck, ending):
    """Files whose names begin with the deck's and with no longer one of another deck in the folder."""
    folder, stem = os.path.dirname(deck), os.path.splitext(os.path.basename(deck))[0].lower()
    names = os.listdir(folder or ".")
    stems = {os.path.splitext(n)[0].lower() for n in names if n.lower().endswith((".bdf", ".dat", ".nas"))}

    def owner(name):
        return max((s for s in stems if os.path.splitext(name)[0].lower().startswith(s)), key=len, default="")

    return sorted(os.path.join(folder, n) for n in names if n.lower().endswith(ending) and owner(n) == stem)


def of_f06(path):
    """Hz, of the first table of real eigenvalues."""
    with open(path, encoding="latin-1") as file:
        lines = file.readlines()
    found, inside = [], False
    for line in lines:
        if "R E A L   E I G E N V A L U E S" in line:
            if found:
                break
            inside = True
        elif inside:
            words = line.split()
            if len(words) == 7 and words[0].isdigit() and words[1].isdigit():
                found.append(float(words[4]))
            elif found and line.startswith("1"):
                break
    return found


def of_op2(path):
    """Hz, of the first table of real eigenvalues."""
    results = OP2(debug=None, log=None, mode=None)
    results.set_results(["eigenvalues"])
    results.read_op2(path, combine=False)
    for table in results.eigenvalues.values():
        # Not of buckling, not complex.
        if type(table).__name__ == "RealEigenvalues":
            return [float(f) for f in table.cycles]
    return []


def printed_frequencies(deck, cards):
    """Hz, and the file that has them. `cards`: of the deck."""
    methods = [card for card in cards if card[0] in ("EIGRL", "EIGR")]
    highest, most = math.inf, None
    if len(methods) == 1 and methods[0][0] == "EIGRL":  # what lies beyond are residual vectors
        fields = [*methods[0], *[""] * 5]
        highest = to_real(fields[3]) or math.inf
        most = int(fields[4]) if fields[4].isdigit() else None
    for read, ending in ((of_f06, ".f06"), (of_op2, ".op2")):
        for path in results_beside(deck, ending) if OP2 or ending == ".f06" else []:
            try:
                found = [f for f in read(path) if f <= highest][:most]
            except Exception:  # versions of Nastran that pyNastran does not read
                continue
            if found:
                return found, path
    return [], ""


def to_real(text):
    """Numbers may lack the E of their exponent."""
    return (
        float(re.sub(r"(?<=[\d.])([+-])", r"e\1", text.lower().replace("d", "e").replace("ee", "e"))) if text else None
    )


def lumped_copy(deck, path):
    """The deck with the masses of elements at their nodes in equal parts, as Nastran has them without
    PARAM,COUPMASS; rotations get none."""
    model = read_deck(deck)
    mass = collections.Counter()
    arms = {}
    for element in model.elements.values():
        if element.type in ("CBUSH", "CBUSH1D", "CELAS1", "CELAS2", "CELAS3", "CELAS4", "PLOTEL"):
            continue
        if not hasattr(element, "Mass"):
            continue
        whole = element.Mass()
        nodes = [node for node in element.node_ids if node]
        if (whole and len(nodes) > 8) or element.type in ("CTRIA6", "CQUAD8"):
            raise ValueError("how Nastran lumps quadratic elements is not known here")
        for node in nodes:
            mass[node] += whole / len(nodes)
        if element.type in ("CBAR", "CBEAM"):
            arms.update({n: True for n, w in zip(nodes, (element.wa, element.wb), strict=True) if any(w)})
    if any(mass[node] for node in arms):
        raise ValueError("beams with offsets")
    for material in model.materials.values():
        if hasattr(material, "rho"):
            material.rho = 1e-9 * (material.rho or 0)
    for one in [*model.properties.values(), *model.elements.values()]:
        for name in ("nsm", "nsm1", "nsm2"):
            if hasattr(one, name):
                value = getattr(one, name)
                setattr(one, name, 0.0 * value if value is not None else value)
    label = max([*model.elements, *model.masses, *model.rigid_elements, 0]) + 1
    for node, value in mass.items():
        if value:
            model.add_conm2(label, node, value)
            label += 1
    model.write_bdf(path, interspersed=False, enddata=True)


def read_deck(deck):
    model, text = BDF(debug=None), read_text(deck)
    once = re.sub(r"(?im)^(\s*begin\s+bulk\s*\n)(\s*\n)*\s*begin\s+bulk\s*\n", r"\1", text)
    with tempfile.TemporaryDirectory() as folder:
        path = deck
        if once != text:
            path = os.path.join(folder, "once.bdf")
            with open(path, "w", encoding="latin-1") as file:
                file.write(once)
        model.read_bdf(path, validate=False, punch=not re.search(r"(?im)^\s*(cend|begin\s+bulk)", text))
    return model


def read_text(path):
    with open(path, encoding="latin-1") as file:
        return file.read()


def held_frequencies(program, deck, held, scale, timeout, folder):
    """Hz, of the deck with its single-point constraints: its free body, reduced with an interface at every node
    that is held, and these held afterwards. `held`: components by node; `scale`: Hz, of those wanted."""
    grids, turning = grids_of(deck)
    groups = {}
    for node, components in held.items():
        if node not in grids:
            continue
        components = {int(c) for c in components if c in ("123456" if node in turning else "123")}
        if not components or components == {6}:  # drilling of a shell
            continue
        whole = len(components) == 6 or (node not in turning and len(components) == 3)
        if not whole and node not in turning:
            raise ValueError("nodes of solids are held in part")
        name = "all" if whole else f"n{node}"
        axes = np.eye(3) if whole else grids[node]
        groups.setdefault(name, (set(range(1, 7)) if whole else components, [], axes))[1].append(node)
    if len(groups) > 20:
        raise ValueError("too many nodes are held in part")
    body = os.path.join(folder, "held.h5")
    if not groups:
        groups = {"any": (set(), [min(turning)] if turning else sorted(grids)[:3], np.eye(3))}
    options = []
    for name, (_, nodes, _) in groups.items():
        table = os.path.join(folder, name + ".txt")
        with open(table, "w") as file:
            file.write("\n".join(map(str, nodes)))
        options += ["--interface", f"{name}=nodes:{table}"]
    command = [program, "reduce", deck, *options, "--no-cache", "--free-modes", "0", "-o", body]
    for modes in (["--max-frequency", str(3 * scale)], ["--modes", "10"], ["--modes", "2"], ["--modes", "0"]):
        done = subprocess.run([*command, *modes], capture_output=True, text=True, timeout=timeout)
        if done.returncode in (0, 4):
            return constrained_frequencies(body, groups, scale)
        if not re.search("(more|fewer|less) modes|--max-frequency", done.stderr):
            break
    errors = [line for line in done.stderr.splitlines() if "error" in line] or ["?"]
    raise ValueError(re.sub(r"^.*?error: ", "", errors[0]))


def constrained_frequencies(body, groups, scale):
    """Hz, ascending; of the free body whose frames, named as the groups, are held in the groups' components.
    `scale`: Hz, of those wanted."""
    with h5py.File(body) as file:
        n, mass = int(file.attrs["modes"]), float(file.attrs["mass"])
        first, second = file["first_moment"][()], file["second_moment"][()]
        moments = file["S_position"][()].reshape(3, 3, n)
        M, K = np.zeros((6 + n, 6 + n)), np.zeros((6 + n, 6 + n))
        M[:3, :3] = mass * np.eye(3)
        M[3:6, :3] = cross(first)
        M[3:6, 3:6] = np.trace(second) * np.eye(3) - second
        M[6:, :3] = file["S"][()].reshape(3, n).T
        for k in range(3):
            i, j = (k + 1) % 3, (k + 2) % 3
            M[6:, 3 + k] = moments[i, j] - moments[j, i]
        M[6:, 6:], K[6:, 6:] = file["mass_matrix"][()].reshape(n, n), file["stiffness"][()].reshape(n, n)
        M = np.tril(M) + np.tril(M, -1).T
        rows = []
        for frame in file["frames"].values():
            name = frame.attrs["name"]
            name = name.decode() if isinstance(name, bytes) else str(name)
            motion = np.zeros((6, 6 + n))
            motion[:3, :3] = motion[3:, 3:6] = np.eye(3)
            motion[:3, 3:6] = -cross(frame["position"][()])
            motion[:3, 6:] = frame["X"][()].reshape(3, n)
            motion[3:, 6:] = frame["X_theta"][()].reshape(3, n)
            components, _, axes = groups[name]
            motion = np.vstack([axes.T @ motion[:3], axes.T @ motion[3:]])
            rows += [motion[c - 1] for c in sorted(components)]
    free = scipy.linalg.null_space(np.array(rows)) if rows else np.eye(6 + n)
    K, M = free.T @ K @ free, free.T @ M @ free
    # The inverse problem: motions almost without mass must not spoil the lowest frequencies.
    shift = (2 * math.pi * scale) ** 2
    inverse = scipy.linalg.eigh(M, K + shift * M, eigvals_only=True)[::-1]
    return [math.sqrt(max(1 / w - shift, 0)) / (2 * math.pi) for w in inverse if w > 1e-12 * inverse[0]]


def cross(a):
    return np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])


def grids_of(deck):
    """Axes in which nodes are held, as columns, by node; and the nodes of shells and bars."""
    model = read_deck(deck)
    turning = set()
    for element in model.elements.values():
        if element.type.startswith(("CQUAD", "CTRIA", "CBAR", "CBEAM", "CBUSH")):
            turning.update(node for node in element.node_ids if node)
    for element in model.rigid_elements.values():
        turning.update(node for node in element.independent_nodes if node)
    return {node: axes_of(model, grid) for node, grid in model.nodes.items()}, turning


def axes_of(model, grid):
    if not grid.Cd() or grid.Cd() < 0:
        return np.eye(3)
    system = model.coords[grid.Cd()]
    if system.type[5] == "S":
        raise ValueError("nodes are held along spherical axes")
    if system.type[5] == "C":
        r = np.array(grid.get_position()) - system.origin
        z = system.k
        along = r - (r @ z) * z
        x = along / np.linalg.norm(along)
        return np.column_stack([x, np.cross(z, x), z])
    return np.column_stack([system.i, system.j, system.k])


def paired(ours, printed):
    """Each printed elastic frequency with the nearest of ours that has no other yet, or None."""
    left, pairs = [f for f in ours if f > ELASTIC * max(printed)], []
    for wanted in (f for f in printed if f > ELASTIC * max(printed)):
        near = min(left, key=lambda f: abs(math.log(f / wanted)), default=None)
        if near is not None and abs(near / wanted - 1) > 0.4:
            near = None
        if near is not None:
            left.remove(near)
        pairs.append((near, wanted))
    return pairs

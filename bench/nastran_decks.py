#!/usr/bin/env python3
"""Reduces every Nastran deck of a folder and prints which become bodies, and why the others do not.

    bench/nastran_decks.py FOLDER [--program build/release/mimbre] [--timeout 120]

The interface are the nodes that the deck holds (SPC), else a node of a shell or a bar or three nodes of a solid.
Decks whose materials have no density get one (--density). Decks without a mesh of their own (parts to be included),
of heat, fluids, rotational symmetry, large strain or aerodynamics alone are no linear structures; the share is of
those that are.

Where results of Nastran lie beside a deck (.f06, .op2) the lowest elastic frequencies are compared, under the deck's
own constraints: once as mimbre reads the deck, with consistent masses, and once of a copy of the deck with lumped
masses, as Nastran has them by default. This needs pyNastran, h5py and SciPy.
"""

import argparse
import collections
import json
import os
import re
import subprocess
import sys
import tempfile

try:
    import nastran_printed
except ImportError:
    nastran_printed = None

ENDINGS = (".bdf", ".dat", ".nas")
ELEMENTS = re.compile(
    r"^(CTETRA|CHEXA|CPENTA|CPYRAM?|CQUAD[48R]?|CTRIA[36R]|CBAR|CBEAM3?|CBEND|CROD|CONROD|CTUBE|CSHEAR|CBUSH|CELAS\d)$"
)
OTHER_PHYSICS = re.compile(
    r"^(CTRIAX6?|CQUADX8?|CQUADX|CPLST[NS]\d|PLSOLID|PLPLANE|CHACAB|CAABSF|CCONEAX|CFLUID\d|MATHP|MATHE|CGEN|ACMODL"
    r"|CELLBOX|CELLWNG|PFLUID)$"
)


CONTACT = re.compile(r"^(BCTABLE|BCTSET|BCONP|BCONTACT|BCTADD)$")


def lines_of(path, depth=0):
    try:
        with open(path, encoding="latin-1") as file:
            text = file.read().splitlines()
    except OSError:
        return
    for line in text:
        include = re.match(r"\s*include\s+['\"]?([^'\"$]+)", line, re.I)
        if include and depth < 5:
            yield from lines_of(os.path.join(os.path.dirname(path), include.group(1).strip()), depth + 1)
        else:
            yield line


def kind_of(path):
    """'' for a linear structure, else what it is."""
    cards = collections.Counter()
    control = []
    bulk = False
    for line in lines_of(path):
        if re.match(r"\s*begin\s+(bulk)?", line, re.I):
            bulk = True
        elif not bulk:
            control.append(line.split("$")[0].strip().upper())
        if line[:1] not in "$+* \t,":
            cards[re.split(r"[,\t]", line)[0][:8].strip().rstrip("*").strip().upper()] += 1
    solution = next((re.sub(r"\W+", " ", c[3:]).strip() for c in control if c.startswith("SOL")), "")
    if not any(ELEMENTS.match(card) for card in cards) or not cards["GRID"]:
        return "no mesh of its own"
    if any(OTHER_PHYSICS.match(card) for card in cards):
        return "fluid, rotational symmetry, plane strain, large strain or generated cards"
    if any(CONTACT.match(card) for card in cards):
        return "contact between parts"
    conducts = (cards["MAT4"] or cards["MAT5"]) and not any(cards[f"MAT{k}"] for k in (1, 2, 3, 8, 9, 10, 11))
    conducts = conducts or any("ANALYSIS" in c and "HEAT" in c for c in control)
    if conducts or solution.split(" ")[0] in ("153", "159"):
        return "heat"
    return ""


def fields_of(line):
    """Of a line of bulk data, the card's name first."""
    text = line.split("$")[0].rstrip()
    if "," in text[:10]:
        return [field.strip() for field in text.split(",")]
    text = text.expandtabs(8)
    width = 16 if text[:8].strip().endswith("*") else 8
    return [text[:8].strip().rstrip("*")] + [text[i : i + width].strip() for i in range(8, 72, width)]


def cards_of(path):
    """Bulk data cards with what goes on in further lines, without the fields that only join lines."""
    card = []
    for line in lines_of(path):
        fields = fields_of(line)
        if not any(fields):
            continue
        if re.match(r"[A-Za-z]", fields[0] or " "):
            if card:
                yield card
            card = [fields[0].upper(), *fields[1:9]]
        elif card and (not fields[0] or fields[0][0] in "+*"):
            card += [""] * ((1 - len(card)) % (4 if line.lstrip()[:1] == "*" else 8)) + fields[1:9]
    if card:
        yield card


def chosen_constraints(path):
    """Numbers of the SPC sets of the case control; none: every set counts."""
    chosen = [int(m[1]) for m in (re.match(r"\s*SPC\s*=\s*(\d+)", line, re.I) for line in lines_of(path)) if m]
    sums = {int(c[1]): [int(x) for x in c[2:] if x.isdigit()] for c in cards_of(path) if c[0] == "SPCADD"}
    return {part for one in chosen[:1] for part in sums.get(one, [one])}


def held_nodes(path):
    """Components that single-point constraints hold, by node."""
    chosen, held = chosen_constraints(path), collections.defaultdict(set)
    for card in cards_of(path):
        if card[0] == "GRID" and len(card) > 7 and card[7].isdigit() and card[7] != "0":
            held[int(card[1])] |= set(card[7])
        if card[0] not in ("SPC", "SPC1") or not card[1].isdigit() or (chosen and int(card[1]) not in chosen):
            continue
        if card[0] == "SPC":
            for k in range(2, len(card) - 1, 3):
                if card[k].isdigit():
                    held[int(card[k])] |= set(card[k + 1])
            continue
        nodes, k = [], 3
        while k < len(card):
            if card[k].upper() == "THRU" and nodes and k + 1 < len(card) and card[k + 1].isdigit():
                nodes += range(nodes[-1] + 1, int(card[k + 1]) + 1)
                k += 1
            elif card[k].isdigit():
                nodes.append(int(card[k]))
            k += 1
        for node in nodes:
            held[node] |= set(card[2])
    return held


CORNERS = {"CQUAD4": 1, "CQUADR": 1, "CQUAD8": 1, "CTRIA3": 1, "CTRIAR": 1, "CTRIA6": 1, "CTETRA": 3, "CPENTA": 3}
CORNERS.update({"CHEXA": 3, "CPYRAM": 3, "CBAR": 1, "CBEAM": 1, "CBUSH": 1, "CONROD": 1, "CROD": 1})


def first_element(path):
    """A node of a shell, else three of a solid, else one of a bar, a bush or a rod."""
    found = {}
    for fields in cards_of(path):
        name, count = fields[0], CORNERS.get(fields[0])
        if count and name not in found:
            start = 2 if name == "CONROD" else 3
            nodes = [field for field in fields[start : start + count] if field.isdigit() and int(field) > 0]
            if len(nodes) == count:
                found[name] = nodes
    return next((found[name] for name in CORNERS if name in found), [])


def solves_for_modes(path):
    """Not for buckling, whose eigenvalues are printed alike."""
    solution = next(
        (m[1].upper() for m in (re.match(r"\s*SOL\s+(\w+)", line, re.I) for line in lines_of(path)) if m), ""
    )
    return solution not in ("5", "105", "SEBUCKL", "BUCKLING")


def interface_of(path):
    """Nodes that the deck holds, else those of an element."""
    held, there = held_nodes(path), {int(c[1]) for c in cards_of(path) if c[0] == "GRID" and c[1].isdigit()}
    fixed = [str(node) for node, what in held.items() if node in there and what >= set("123")]
    turned = any(node in there and what >= set("123456") for node, what in held.items())
    return fixed if turned or len(fixed) >= 3 else first_element(path)


def reduce(program, deck, interface, body, timeout, more):
    nodes = body + ".txt"
    with open(nodes, "w") as file:
        file.write("\n".join(interface))
    command = [program, "reduce", deck, "--interface", "element=nodes:" + nodes, "--no-cache", "--json"]
    command += ["-o", body] + more + ([] if "--modes" in more else ["--modes", "4", "--free-modes", "6"])
    command += ["--free-modes", "1"] if "--modes" in more else []
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=timeout)
    except subprocess.TimeoutExpired:
        return None, f"takes longer than {timeout:g} s"
    if done.returncode in (0, 4):
        return json.loads(done.stdout), ""
    message = [line for line in done.stderr.splitlines() if "error" in line] or done.stderr.splitlines() or ["?"]
    text = re.sub(r"^.*?error: ", "", message[0])
    more = f" (and {len(message) - 1} more)" if len(message) > 1 else ""
    return None, text[:150] + more


def reduce_deck(program, deck, body, timeout):
    """As reduce, with another interface, a density or fewer modes where the deck needs them; and what was added."""
    interface = interface_of(deck)
    result, why = reduce(program, deck, interface, body, timeout, [])
    if re.search("no hold in all six|no node of the model|nothing that could deform|model has no node", why):
        interface = first_element(deck)
        result, why = reduce(program, deck, interface, body, timeout, [])
    note, more = "", []
    if "density" in why:
        first, more = why, ["--density", "7850"]
        result, why = reduce(program, deck, interface, body, timeout, more)
        why = first if "every material has its own" in why else why
        note = " with --density"
    if "more modes" in why or "fewer modes" in why:
        result, why = reduce(program, deck, interface, body, timeout, [*more, "--modes", "1"])
    return result, why, note


def compare(program, deck, timeout, folder):
    """Prints the frequencies of a deck beside those that Nastran printed, with consistent and lumped masses."""
    printed, source = nastran_printed.printed_frequencies(deck, list(cards_of(deck)))
    elastic = [f for f in printed if f > nastran_printed.ELASTIC * max(printed)]
    if max(printed, default=0) < 1e-6 or not solves_for_modes(deck):
        return
    print(f"         {os.path.basename(source)} {'Hz':>6} " + " ".join(f"{f:9.5g}" for f in elastic[:8]), flush=True)
    for kind in ("consistent", "lumped"):
        path = deck
        try:
            if kind == "lumped":
                path = os.path.join(folder, "lumped.bdf")
                nastran_printed.lumped_copy(deck, path)
            ours = nastran_printed.held_frequencies(program, path, held_nodes(path), max(printed), timeout, folder)
        except Exception as why:
            print(f"         {kind}: not compared: {str(why).splitlines()[0][:110]}")
            continue
        pairs = nastran_printed.paired(ours, printed)
        off = " ".join(f"{100 * (a / b - 1):+8.2g}%" if a else " " * 9 for a, b in pairs[:8])
        print(f"         {kind:>12}, off: {off}", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder")
    parser.add_argument("--program", default="build/release/mimbre")
    parser.add_argument("--timeout", type=float, default=120)
    options = parser.parse_args()
    decks = []
    for folder, _, names in os.walk(options.folder):
        decks += [os.path.join(folder, name) for name in names if name.lower().endswith(ENDINGS)]
    linear = reduced = 0
    reasons = collections.Counter()
    with tempfile.TemporaryDirectory() as scratch:
        body = os.path.join(scratch, "body.h5")
        for deck in sorted(decks):
            name = os.path.relpath(deck, options.folder)
            kind = kind_of(deck)
            if kind:
                print(f"-        {name}: {kind}")
                continue
            linear += 1
            result, why, note = reduce_deck(options.program, deck, body, options.timeout)
            if result is None:
                print(f"refused  {name}: {why}", flush=True)
                reasons[re.sub(r"[-+.\d]+", "#", re.sub(r"'.*?'", "''", why))[:70]] += 1
                continue
            reduced += 1
            found = [f for f in result.get("free_frequencies_hz", []) if f]
            print(f"reduces  {name}{note}: {', '.join(f'{f:.5g} Hz' for f in found[:3])}", flush=True)
            if nastran_printed:
                compare(options.program, deck, options.timeout, scratch)
    share = 100 * reduced / max(linear, 1)
    print(f"\n{reduced} of {linear} linear structures reduce ({share:.0f} %), of {len(decks)} files")
    for why, count in reasons.most_common(25):
        print(f"{count:5d}  {why}")
    return 0


if __name__ == "__main__":
    sys.exit(main())

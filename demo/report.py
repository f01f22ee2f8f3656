"""The report: all figures as JSON, and a page of Markdown to read."""

import json


def write(folder, figures):
    """Writes report.json and report.md."""
    (folder / "report.json").write_text(json.dumps(figures, indent=1) + "\n", encoding="utf-8")
    (folder / "report.md").write_text(page(figures), encoding="utf-8")


def page(figures):
    """The report as Markdown."""
    sections = [
        "# What the demo did",
        f"Blender {figures['blender']}, lissom {figures['lissom']}, {figures['processors']} processors, "
        f"{figures['seconds']:.0f} s in all, of which {figures['picture_seconds']:.0f} s for the pictures. "
        "Seconds of the jobs are for the operators as a whole.",
        *_pose(figures["pose"]),
        *_remeshed(figures["remeshed"]),
        *_suzanne(figures["suzanne"]),
        *_inbetween(figures["inbetween"]),
        *_arcs(figures["arcs"]),
        *_elbow(figures["elbow"]),
        *_drawing(figures["drawing"]),
    ]
    return "\n\n".join(sections) + "\n"


def expressions(rows):
    """The table of errors against the known answer."""
    columns = {
        "rms": "RMS error", "p99": "99 % below", "max": "Max error",
        "motion_rms": "RMS motion", "motion_max": "Max motion", "closest_point_rms": "Closest point, RMS",
    }  # fmt: skip
    mean = {column: sum(row[column] for row in rows) / len(rows) for column in columns}
    lines = [{"expression": f"**mean of all {len(rows)}**", **mean}]
    body = [(row["expression"], *(f"{row[column]:.3f}" for column in columns)) for row in [*rows, *lines]]
    return table(("Expression", *columns.values()), body)


def stale(rows, text):
    """The lines of a document that are as this table's by their first column, and not by the others."""
    known = {line.split("|")[1]: line for line in expressions(rows).splitlines()[2:]}
    return [line for line in text.splitlines() if known.get(line[1:].partition("|")[0], line) != line]


def table(heads, rows):
    """A Markdown table; all columns but the first are aligned to the right."""
    lines = ["| " + " | ".join(heads) + " |", "|---|" + "---:|" * (len(heads) - 1)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows])


def _pose(figures):
    rows = [
        (row["pose"], str(row["free_vertices"]), f"{row['bind_seconds']:.2f} s", f"{row['seconds']:.2f} s")
        for row in figures["poses"]
    ]
    yield "## Pose"
    yield f"A bust of {figures['vertices']} vertices."
    yield table(("Pose", "Free vertices", "Bind", "Solve, as shape key"), rows)
    yield "![Pose](pose.png)"


def _remeshed(figures):
    yield "## Transfer to another person, remeshed"
    yield (
        f"From {figures['source_vertices']} vertices ({figures['source_triangles']} triangles) to "
        f"{figures['target_vertices']} ({figures['target_triangles']}), which Blender's Decimate left of the "
        f"other person. {_transfer(figures)}"
    )
    yield (
        "Distance to the known answer, identity + expression, in percent of the diagonal of the target's "
        "bounding box, over all vertices. Beside it: how far the expression moves them, and the error of "
        "copying offsets from the closest point of the source that faces the same way."
    )
    yield expressions(figures["expressions"])
    place = figures["distance_to_full_surface"]
    yield (
        f"The answer is read off the surface before it was thinned out, from which the target's vertices are "
        f"{place['rms']:.3f} % away (root mean square; at most {place['max']:.3f} %)."
    )
    yield "![Transfer to another person](remeshed.png)"


def _suzanne(figures):
    yield "## Transfer to Suzanne"
    yield (
        f"From {figures['source_vertices']} vertices of skin to {figures['target_vertices']} "
        f"({figures['target_triangles']} triangles). {_transfer(figures)}"
    )
    seen = figures["eye_visible_percent"]
    blinks = ", ".join(
        f"{name} {seen[f'{name} front']:.1f} % from the front and {seen[f'{name} above']:.1f} % from above"
        for name in ("eyeBlink_L", "eyeBlink_R")
    )
    yield (
        f"Of an eye's outline is seen: at rest {seen['None front']:.0f} %, in {blinks}. Over all keys, "
        f"{figures['flipped_percent']:.2f} % of the triangles are turned over."
    )
    yield "![Transfer to Suzanne](suzanne.png)"
    yield "![All keys on Suzanne](suzanne_keys.png)"


def _transfer(figures):
    return (
        f"Linked by {figures['markers']} marker pairs. Fit: {figures['fit_seconds']:.1f} s; "
        f"{figures['keys']} keys: {figures['transfer_seconds']:.1f} s."
    )


def _arcs(figures):
    lid, jaw, blink = figures["lid"], figures["jaw"], figures["blink"]
    yield "## Arcs on known ground"
    yield (
        f"A lid that turns by 100 degrees about a ball, {lid['keys']} shape keys: it sinks in by "
        f"{100 * lid['depth']['straight']:.1f} % of the radius on the straight line, by "
        f"{100 * lid['depth']['lissom']:.2f} % on the baked arc."
    )
    yield "![A lid over a ball](lid.png)"
    off = jaw["off_circle_mm"]
    yield (
        f"jawOpen: the chin is off its best circle by {off['straight']:.2f} mm on the straight line, by "
        f"{off['lissom']:.2f} mm on the arc."
    )
    yield "![The chin's path](jaw.png)"
    deeper = blink["deeper_mm"]
    yield (
        "eyeBlink_L over the eyeball's best sphere: a vertex sinks in by up to "
        f"{deeper['straight']:.2f} mm more than at the deeper of its ends on the straight line, by "
        f"{deeper['plain']:.2f} mm on the arc, by {deeper['clear']:.2f} mm with clearance."
    )
    yield "![A blink](blink.png)"
    for rotation, rows in figures["twist"].items():
        off = ", ".join(f"{row['degrees_off']:.2f} at {row['turns']} turns" for row in rows)
        yield f"A bar half way to a twist, degrees that its end is off, `{rotation}`: {off}."
    yield "![Twisted bars](twist.png)"


def _elbow(figures):
    section = figures["section_percent"]
    yield "## An arm on its bone"
    yield (
        f"An arm bent by 120 degrees: its section at the elbow keeps {section['by weights']:.0f} % by "
        f"weights, {section['corrected']:.0f} % with a corrective that the bone drives, and "
        f"{section['arc']:.0f} % by an arc of {figures['keys']} shape keys whose slider the bone drives."
    )
    yield "![An arm on its bone](elbow.png)"


def _drawing(figures):
    flipped = figures["flipped"]
    yield "## Two drawings"
    yield (
        f"A drawing as a mesh of {figures['vertices']} vertices and {figures['triangles']} triangles, laid "
        f"on a second one by pins; meshing, pose and two arcs took {figures['seconds']:.1f} s. At 50 times "
        f"along the arc, at most {flipped['consistent']} triangles are flipped with consistent turns and "
        f"{flipped['inconsistent']} without; no vertex leaves the plane by more than "
        f"{figures['off_plane']:g}."
    )
    yield "![Two drawings](drawing.png)"


def _inbetween(figures):
    edge, depth = figures["turn_edge_error_percent"], figures["blink_depth_mm"]
    yield "## In-between"
    yield (
        f"A head of {figures['turn_vertices']} vertices from one shoulder to the other: {figures['keys']} "
        f"shape keys under one slider in {figures['turn_seconds']:.1f} s. Half way, edge lengths are off by "
        f"{edge['straight']:.1f} % on the straight way and by {edge['lissom']:.1f} % on the baked one (root "
        "mean square, against the mean of both ends)."
    )
    yield (
        f"A blink of {figures['blink_vertices']} vertices: {figures['keys']} shape keys in "
        f"{figures['blink_seconds']:.1f} s. On their way the lids sink into the eyes by up to "
        f"{depth['straight']:.2f} mm more than at either end on the straight way, by "
        f"{depth['lissom']:.2f} mm on the baked one."
    )
    yield "![In-between](inbetween.png)"

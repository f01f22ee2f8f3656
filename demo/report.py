"""The report: all figures as JSON, and a page of Markdown to read."""

import json


def write(folder, figures):
    """Writes report.json and report.md."""
    (folder / "report.json").write_text(json.dumps(figures, indent=1) + "\n", encoding="utf-8")
    (folder / "report.md").write_text(page(figures), encoding="utf-8")


def page(figures):
    """The report as Markdown."""
    pose, remeshed, suzanne, inbetween = (figures[job] for job in ("pose", "remeshed", "suzanne", "inbetween"))
    edge, depth = inbetween["turn_edge_error_percent"], inbetween["blink_depth_mm"]
    lines = [
        "# What the demo did",
        "",
        f"Blender {figures['blender']}, lissom {figures['lissom']}, {figures['processors']} processors, "
        f"{figures['seconds']:.0f} s in all, of which {figures['picture_seconds']:.0f} s for the pictures.",
        "",
        "## Pose",
        "",
        f"A bust of {pose['vertices']} vertices. Seconds are for the operators as a whole.",
        "",
        *table(
            ("Pose", "Free vertices", "Bind", "Solve, as shape key"),
            [
                (p["pose"], str(p["free_vertices"]), f"{p['bind_seconds']:.2f} s", f"{p['seconds']:.2f} s")
                for p in pose["poses"]
            ],
        ),
        "",
        "![Pose](pose.png)",
        "",
        "## Transfer to another person, remeshed",
        "",
        f"From {remeshed['source_vertices']} vertices ({remeshed['source_triangles']} triangles) to "
        f"{remeshed['target_vertices']} ({remeshed['target_triangles']}) that Blender's Decimate left of the other "
        f"person, linked by {remeshed['markers']} marker pairs. Fit: {remeshed['fit_seconds']:.1f} s; "
        f"{remeshed['keys']} keys: {remeshed['transfer_seconds']:.1f} s.",
        "",
        "Distance to the known answer, identity + expression, in percent of the diagonal of the target's bounding box, "
        "over all vertices. Beside it: how far the expression moves them, and the error of copying offsets "
        "from the closest point of the source that faces the same way.",
        "",
        *expressions(remeshed["expressions"]),
        "",
        "![Transfer to another person](remeshed.png)",
        "",
        "## Transfer to Suzanne",
        "",
        f"From {suzanne['source_vertices']} vertices of skin to {suzanne['target_vertices']} vertices ({suzanne['target_triangles']} triangles), linked by "
        f"{suzanne['markers']} marker pairs. Fit: {suzanne['fit_seconds']:.1f} s; {suzanne['keys']} keys: "
        f"{suzanne['transfer_seconds']:.1f} s.",
        "",
        "![Transfer to Suzanne](suzanne.png)",
        "",
        "## In-between",
        "",
        f"A head of {inbetween['turn_vertices']} vertices from one shoulder to the other: {inbetween['keys']} "
        f"shape keys under one slider in {inbetween['turn_seconds']:.1f} s. Half way, edge lengths are off by "
        f"{edge['straight']:.1f} % (root mean square, against the mean of both ends) on the straight way, by "
        f"{edge['lissom']:.1f} % on the baked one.",
        "",
        f"A blink of {inbetween['blink_vertices']} vertices: {inbetween['keys']} shape keys in "
        f"{inbetween['blink_seconds']:.1f} s. On their way the lids sink into the eyes by up to "
        f"{depth['straight']:.2f} mm more than at either end on the straight way, {depth['lissom']:.2f} mm on the "
        "baked one.",
        "",
        "![In-between](inbetween.png)",
        "",
    ]
    return "\n".join(lines)


def expressions(rows):
    """The table of errors against the known answer."""
    columns = ("rms", "p99", "max", "motion_rms", "motion_max", "closest_point_rms")
    heads = ("Expression", "RMS error", "99 % below", "Max error", "RMS motion", "Max motion", "Closest point, RMS")
    mean = {column: sum(row[column] for row in rows) / len(rows) for column in columns}
    body = [(row["expression"], *(f"{row[column]:.3f}" for column in columns)) for row in rows]
    return table(heads, [*body, ("**mean**", *(f"{mean[column]:.3f}" for column in columns))])


def table(heads, rows):
    """Lines of a Markdown table; all columns but the first are aligned to the right."""
    lines = ["| " + " | ".join(heads) + " |", "|---|" + "---:|" * (len(heads) - 1)]
    return lines + ["| " + " | ".join(row) + " |" for row in rows]

:- module(schema, [ fact_schema/2           % ?Indicator, ?Meaning
                  ]).

/** <module> The facts that a scene may hold

One line for each row of docs/facts.md. A scene's module declares exactly these predicates, so a
rule that asks for a fact which a scene lacks fails instead of raising an error.
*/

%!  fact_schema(?Indicator, ?Meaning) is nondet.
%
%   Facts of form Indicator may be loaded, and mean Meaning.

fact_schema(scene/1,         "the scene's name").
fact_schema(scale/1,         "metric or unknown").
fact_schema(up/3,            "unit vector upwards; absent if not known").
fact_schema(view/2,          "a picture and its file name").
fact_schema(vertex/1,        "a 3-D vertex").
fact_schema(point/4,         "where a vertex is").
fact_schema(point_cov/7,     "its covariance").
fact_schema(vertex_label/2,  "position label of the paper").
fact_schema(observed/6,      "pixel at which a view saw a vertex").
fact_schema(edge/3,          "a straight edge between two vertices").
fact_schema(edge_length/3,   "its length").
fact_schema(edge_support/2,  "share of it found in the views that could see it").
fact_schema(face/1,          "a flat face").
fact_schema(evidence/2,      "measured or implied").
fact_schema(plane/5,         "unit outward normal and offset").
fact_schema(plane_sd/3,      "deviation of the normal and of the offset").
fact_schema(corner/3,        "the I-th vertex of a face's outline").
fact_schema(bounds/2,        "an edge is part of a face's outline").
fact_schema(area/3,          "area of a face").
fact_schema(length/3,        "longer side of the least rectangle round a face").
fact_schema(width/3,         "shorter side of that rectangle").
fact_schema(fill/3,          "area over the least rectangle's").
fact_schema(coverage/2,      "share of a face seen in at least one view").
fact_schema(thing/1,         "a connected group of faces judged as one object").
fact_schema(part_of/2,       "a face or loose edge belongs to a thing").
fact_schema(thing_size/4,    "sides of the least box round a thing, longest first").
fact_schema(share/3,         "area of a face over the silhouette of its thing").
fact_schema(protrusion/3,    "how far the thing reaches in front of a face").
fact_schema(angle/4,         "angle between outward normals").
fact_schema(adjoins/3,       "two faces share an edge").
fact_schema(dihedral/4,      "angle through the solid at a shared edge").
fact_schema(convex/2,        "two faces meet bulging outwards").
fact_schema(concave/2,       "two faces meet bulging inwards").
fact_schema(opposite/2,      "outward normals opposed, outlines overlap").
fact_schema(coplanar/2,      "two faces in one plane").
fact_schema(offset/4,        "signed distance of a face's middle from another's plane").
fact_schema(tilt/3,          "0 level, 90 upright").
fact_schema(upward/1,        "the outward normal points up").
fact_schema(downward/1,      "the outward normal points down").
fact_schema(elevation/3,     "height of a face's middle above the thing's lowest point").
fact_schema(top_of/3,        "height of the highest point of a face or loose edge").
fact_schema(bottom_of/3,     "height of the lowest point of a face or loose edge").
fact_schema(clear_below/2,   "free height under most of a face").
fact_schema(overlap/3,       "share of the smaller face's plan over the other").

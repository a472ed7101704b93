:- module(facetlog_origin, [ origin/2         % +About, -Origin
                           ]).

/** <module> Where it comes from

From a thing, piece, opening, face, edge or fact of the current scene down to the vertices and to the pixels in which
views saw them.
*/

:- use_module(library(lists)).
:- use_module(library(apply)).
:- use_module(library(error)).
:- use_module(facetlog_kb(schema)).
:- use_module(facetlog_kb(scene)).

%!  origin(+About, -Origin) is det.
%
%   About is the name of a thing, piece, opening, face, edge, vertex or view, or the beginning of a
%   fact: its functor with at least its keys, further arguments left out or unbound. Origin is one of
%
%     - thing(Name, Sizes, Faces, Edges): origins of its faces and loose edges;
%     - piece(Name, Things, Sizes, Heights, Measured, Rounds, Faces): Measured is [yes] where some of
%       it was seen; origins of the faces that are mostly its own;
%     - opening(Name, Things, Sizes, Heights, Pieces, Faces): the pieces along its rim, and origins of
%       the faces that it is in;
%     - face(Name, Things, Evidence, Planes, PlaneSds, Corners): origins of its vertices in order;
%     - edge(Name, Evidence, Lengths, Supports, Ends, Faces): origins of two vertices, and the faces
%       that it bounds;
%     - vertex(Name, Places, Covariances, Labels, Sightings);
%     - view(Name, Files, Vertices): the vertices that it saw;
%     - facts(Facts, Origins): the facts, and the origins of what they name.
%
%   What a scene may not have is a list of at most one term, with the arguments of its fact.
%
%   @error existence_error(name, About) if the scene does not have it.

origin(About, Origin) :-
    must_be(callable, About),
    (   named(About, Origin0)
    ->  Origin = Origin0
    ;   facts_about(About, Facts),
        Facts \== []
    ->  findall(Name, ( member(Fact, Facts), arg(_, Fact, Name), has_origin(Name) ), Names0),
        list_to_set(Names0, Names),
        findall(Origin1, ( member(Name, Names), named(Name, Origin1) ), Origins),
        Origin = facts(Facts, Origins)
    ;   existence_error(name, About)
    ).

facts_about(About, Facts) :-
    functor(About, Functor, Given),
    fact_schema(Functor/Arity, _),
    Arity >= Given,
    !,
    About =.. [_|Args],
    functor(Fact, Functor, Arity),
    Fact =.. [_|All],
    append(Args, _, All),
    findall(Fact, fact(Fact), Facts).

has_origin(Name) :- atom(Name), fact(face(Name)), !.
has_origin(Name) :- atom(Name), fact(vertex(Name)), !.
has_origin(Name) :- atom(Name), fact(edge(Name, _, _)), !.
has_origin(Name) :- atom(Name), fact(thing(Name)), !.
has_origin(Name) :- atom(Name), fact(piece(Name)), !.
has_origin(Name) :- atom(Name), fact(opening(Name)), !.

named(Name, face(Name, Things, Evidence, Planes, Sds, Corners)) :-
    fact(face(Name)),
    !,
    found(T, part_of(Name, T), Things),
    found(E, evidence(Name, E), Evidence),
    found(plane(A, B, C, D), plane(Name, A, B, C, D), Planes),
    found(sd(Tilt, Offset), plane_sd(Name, Tilt, Offset), Sds),
    findall(I-V, fact(corner(Name, I, V)), Numbered),
    keysort(Numbered, Ordered),
    findall(Corner, ( member(_-V, Ordered), vertex(V, Corner) ), Corners).
named(Name, edge(Name, Evidence, Lengths, Supports, [From, To], Faces)) :-
    fact(edge(Name, V1, V2)),
    !,
    found(E, evidence(Name, E), Evidence),
    found(length(L, Sd), edge_length(Name, L, Sd), Lengths),
    found(S, edge_support(Name, S), Supports),
    vertex(V1, From),
    vertex(V2, To),
    found(F, bounds(Name, F), Faces0),
    sort(Faces0, Faces).
named(Name, thing(Name, Sizes, Faces, Edges)) :-
    fact(thing(Name)),
    !,
    found(size(L, W, H), thing_size(Name, L, W, H), Sizes),
    found(X, part_of(X, Name), Members),
    partition(is_face, Members, FaceNames, EdgeNames),
    maplist(named, FaceNames, Faces),
    maplist(named, EdgeNames, Edges).
named(Name, piece(Name, Things, Sizes, Heights, Measured, Rounds, Faces)) :-
    fact(piece(Name)),
    !,
    found(T, piece_of(Name, T), Things),
    found(size(L, W, H, Sd), piece_size(Name, L, W, H, Sd), Sizes),
    found(from(Low, High, HeightSd), piece_heights(Name, Low, High, HeightSd), Heights),
    found(yes, piece_measured(Name), Measured),
    found(R, piece_round(Name, R), Rounds),
    found(F, piece_face(Name, F), FaceNames),
    maplist(named, FaceNames, Faces).
named(Name, opening(Name, Things, Sizes, Heights, Pieces, Faces)) :-
    fact(opening(Name)),
    !,
    found(T, opening_of(Name, T), Things),
    found(size(L, W, Sd), opening_size(Name, L, W, Sd), Sizes),
    found(from(Low, High, HeightSd), opening_heights(Name, Low, High, HeightSd), Heights),
    found(P, frames(P, Name), Pieces),
    findall(F, ( fact(opening_in(Name, F)), is_face(F) ), FaceNames),
    maplist(named, FaceNames, Faces).
named(Name, view(Name, Files, Vertices)) :-
    fact(view(Name, _)),
    !,
    found(File, view(Name, File), Files),
    found(V, observed(V, Name, _, _, _, _), Vertices).
named(Name, Vertex) :-
    fact(vertex(Name)),
    vertex(Name, Vertex).

is_face(Name) :-
    fact(face(Name)).

vertex(Name, vertex(Name, Places, Covariances, Labels, Sightings)) :-
    found(at(X, Y, Z), point(Name, X, Y, Z), Places),
    found(cov(XX, XY, XZ, YY, YZ, ZZ), point_cov(Name, XX, XY, XZ, YY, YZ, ZZ), Covariances),
    found(Label, vertex_label(Name, Label), Labels),
    findall(seen(View, File, U, W, SdU, SdW),
            ( fact(observed(Name, View, U, W, SdU, SdW)),
              ( fact(view(View, File0)) -> File = File0 ; File = View ) ),
            Sightings).

found(Template, Fact, Found) :-
    findall(Template, fact(Fact), Found).

:- module(facetlog_origin, [ origin/2         % +About, -Origin
                           ]).

/** <module> Where it comes from

From a thing, piece, opening, face, edge or fact of the current scene down to the vertices and to the pixels in which
views saw them.
*/

:- use_module(library(lists)).
:- use_module(library(apply)).
:- use_module(library(error)).
:- use_module(library(solution_sequences)).
:- use_module(facetlog_kb(schema)).
:- use_module(facetlog_kb(prove)).
:- use_module(facetlog_kb(compare)).
:- use_module(facetlog_kb(scene)).

%!  origin(+About, -Origin) is det.
%
%   About is the name of a thing, piece, opening, face, edge, vertex or view, or the beginning of a
%   fact: its functor with at least its keys, further arguments left out or unbound. Origin is a term
%   with the fields of the record of that name in kb/explaining/origin.py, in their order. What a scene
%   may not have is a list of at most one value.
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
        findall(Name-Args, ( member(Fact, Facts), Fact =.. [Name|Args] ), Written),
        Origin = facts(Written, Origins)
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
has_origin(Name) :- atom(Name), hole(Name, _, _), !.

hole(Name, opening, Thing) :- fact(opening_of(Name, Thing)).
hole(Name, hollow, Thing) :- fact(hollow_of(Name, Thing)).

named(Name, face(Name, Things, Evidence, Planes, Corners)) :-
    fact(face(Name)),
    !,
    found(T, part_of(Name, T), Things),
    found(E, evidence(Name, E), Evidence),
    found(Tilt, plane_sd(Name, Tilt, _), Tilts),
    found(Offset, plane_sd(Name, _, Offset), Offsets),
    found(plane(at(A, B, C), D, Tilts, Offsets), plane(Name, A, B, C, D), Planes),
    findall(I-V, fact(corner(Name, I, V)), Numbered),
    keysort(Numbered, Ordered),
    findall(Corner, ( member(_-V, Ordered), vertex(V, Corner) ), Corners).
named(Name, edge(Name, Evidence, Lengths, Sds, Supports, [From, To], Faces)) :-
    fact(edge(Name, V1, V2)),
    !,
    found(E, evidence(Name, E), Evidence),
    found(L, edge_length(Name, L, _), Lengths),
    found(Sd, edge_length(Name, _, Sd), Sds),
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
named(Name, piece(Name, Things, size(L, W, H), Sd, Heights, Measured, Round, Faces, Shapes)) :-
    fact(piece(Name)),
    !,
    found(T, piece_of(Name, T), Things),
    fact(piece_size(Name, L, W, H, Sd)),
    found(from(Low, High, HeightSd), piece_heights(Name, Low, High, HeightSd), Heights),
    ( fact(piece_measured(Name)) -> Measured = true ; Measured = false ),
    fact(piece_round(Name, Round)),
    found(F, piece_face(Name, F), FaceNames),
    maplist(named, FaceNames, Faces),
    findall(Shape, limit(1, piece_shape(Name, Shape)), Shapes).
named(Name, opening(Name, Kind, Things, size(L, W), Sd, Heights, Pieces, Faces)) :-
    hole(Name, Kind, Thing),
    !,
    Things = [Thing],
    fact(opening_size(Name, L, W, Sd)),
    found(from(Low, High, HeightSd), opening_heights(Name, Low, High, HeightSd), Heights),
    found(P, frames(P, Name), Pieces),
    findall(F, ( fact(opening_in(Name, F)), is_face(F) ), FaceNames),
    maplist(named, FaceNames, Faces).
named(Name, view(Name, File, Vertices)) :-
    fact(view(Name, File)),
    !,
    found(V, observed(V, Name, _, _, _, _), Vertices).
named(Name, Vertex) :-
    fact(vertex(Name)),
    vertex(Name, Vertex).

%   shape(Shape, Low, Shares): what the words of the vocabulary say that a piece is, how surely, and what
%   that rests on, share(Measure, Value, Limit).
piece_shape(Piece, shape(Shape, Low, Shares)) :-
    member(Shape, [board, bar, block]),
    Test =.. [Shape, Piece],
    evaluate(Test, vocabulary, Proof),
    Proof = proof(holds, Low, _, _, _, _),
    findall(Share, share_in(Proof, Share), Shares).

share_in(proof(_, _, _, Test, Detail, Children), Share) :-
    (   comparison(Test, Measure, _),
        arg(1, Detail, Value)
    ->  arg(4, Detail, Within),
        ( Within = soft(Bound, _) -> true ; Bound = Within ),
        arg(1, Bound, Limit),
        Share = share(Measure, Value, Limit)
    ;   member(Child, Children),
        share_in(Child, Share)
    ).

is_face(Name) :-
    fact(face(Name)).

vertex(Name, vertex(Name, Places, Deviations, Labels, Sightings)) :-
    found(at(X, Y, Z), point(Name, X, Y, Z), Places),
    findall(at(SdX, SdY, SdZ),
            ( fact(point_cov(Name, XX, _, _, YY, _, ZZ)),
              maplist(deviation, [XX, YY, ZZ], [SdX, SdY, SdZ]) ),
            Deviations),
    found(Label, vertex_label(Name, Label), Labels),
    findall(seen(View, File, U, W, SdU, SdW),
            ( fact(observed(Name, View, U, W, SdU, SdW)),
              ( fact(view(View, File0)) -> File = File0 ; File = View ) ),
            Sightings).

%   Rounding may leave a variance just below 0.
deviation(Variance, Sd) :-
    Sd is sqrt(max(0.0, Variance)).

found(Template, Fact, Found) :-
    findall(Template, fact(Fact), Found).

:- module(grouping, [ separate/2,             % +FacesAndEdges, -Groups
                      distance/3,             % +Point, +Point, -Distance
                      dot/3                   % +Vector, +Vector, -Product
                    ]).

/** <module> Which supports are one leg

Supports that adjoin near their feet belong together, and so do narrow ones whose feet stand at nearly one place, or
are joined by others that do. A face that falls apart on its way to the ground, as the front of a gate
does, is a support of each of the posts that it is part of, and joins none of them. To compare each with each would cost the square of their number: feet
are sorted into cells so small that those of one cell are near in any case, and only cells are
compared.
*/

:- use_module(library(lists)).
:- use_module(library(aggregate)).
:- use_module(library(apply)).
:- use_module(library(assoc)).
:- use_module(library(pairs)).
:- use_module(library(ugraphs)).
:- use_module(facetlog_kb(scene)).

tolerance(apart, 0.15).   % of the thing's length: feet nearer than this are one leg's
tolerance(lying, 45).     % degrees from level
tolerance(sure,  3).      % deviations: so far before a face is in front of it

%!  separate(+Supports, -Groups) is det.
%
%   Groups are lists of the Supports that belong together: faces that adjoin, and whatever stands
%   on the ground at nearly one place. A square leg with four faces is one group. A face that stands on
%   several legs is in the group of each. What stands adjoins where it stands, not by an apron above.

separate(Supports0, Groups) :-
    sort(Supports0, Faces),
    halfway_up(Faces, Half),
    findall(Support, ( member(Face, Faces), support_of(Face, Half, Support) ), Supports1),
    sort(Supports1, Supports),
    findall(Foot, ( member(S, Supports), narrow_foot(S, Foot) ), Feet),
    cells(Feet, Cells),
    findall(Link, link(Supports, Cells, Half, Link), Links),
    components(Supports, Links, Of),
    findall(Bridge, bridge(Cells, Of, Bridge), Bridges),
    (   Bridges == []
    ->  Joined = Of
    ;   append(Links, Bridges, All),
        components(Supports, All, Joined)
    ),
    findall(First-Support, ( member(Support, Supports), get_assoc(Support, Joined, First) ), Keyed),
    keysort(Keyed, Sorted),
    group_pairs_by_key(Sorted, Grouped),
    pairs_values(Grouped, Groups0),
    maplist(maplist(face_of_support), Groups0, Groups1),
    msort(Groups1, Groups).

                 /*******************************
                 *             LINKS            *
                 *******************************/

%   A support is a face or edge, or leg(Face, Stretch): what stands of a Face where its section halfway
%   up the lowest support has this Stretch, one of several.
support_of(Face, Half, Support) :-
    (   stretches(Face, Half, Stretches)
    ->  member(Stretch, Stretches),
        Support = leg(Face, Stretch)
    ;   Support = Face
    ).

face_of_support(Support, Face) :-
    ( Support = leg(Face, _) -> true ; Face = Support ).

%   Links join supports: those that adjoin, those of one cell, and one of each of two cells that
%   touch, if they have feet within reach.
link(Supports, _, Half, SupportA-SupportB) :-
    findall(Face-Support, ( member(Support, Supports), face_of_support(Support, Face) ), Keyed),
    keysort(Keyed, Sorted),
    group_pairs_by_key(Sorted, Grouped),
    list_to_assoc(Grouped, Known),
    member(A-SupportsA, Grouped),
    fact(adjoins(A, B, Edge)),
    A @< B,
    get_assoc(B, Known, SupportsB),
    \+ ( number(Half), stands(A), stands(B), above(Edge, Half) ),
    support_at(SupportsA, Edge, SupportA),
    support_at(SupportsB, Edge, SupportB).
link(_, Cells, _, A-B) :-
    gen_assoc(_, Cells, Feet),
    append(Before, [foot(B, _, _)|_], Feet),
    once(( member(foot(A, _, _), Before), \+ one_before_other(A, B) )).
link(_, Cells, _, Link) :-
    cell_pair(Cells, 1, Feet1, Feet2),
    member(Foot2, Feet2),
    once(within_reach(Feet1, [Foot2], Link)).

%   Feet within reach may also lie two cells apart: asked only where nothing else joins them.
bridge(Cells, Of, Link) :-
    cell_pair(Cells, 2, Feet1, Feet2),
    Feet1 = [foot(A, _, _)|_],
    Feet2 = [foot(B, _, _)|_],
    get_assoc(A, Of, First),
    \+ get_assoc(B, Of, First),
    once(within_reach(Feet1, Feet2, Link)).

within_reach(Feet1, Feet2, A-B) :-
    member(foot(A, P, Reach), Feet1),
    member(foot(B, Q, _), Feet2),
    distance(P, Q, Distance),
    Distance =< Reach,
    \+ one_before_other(A, B).

%   Sides of one leg look away from it: none lies before another, unless they adjoin.
one_before_other(A, B) :-
    ( before(A, B) ; before(B, A) ),
    !.

before(A, B) :-
    fact(offset(A, B, Distance, Sd)),
    tolerance(sure, Sds),
    Distance > Sds*Sd.

%   Components of a graph; each support with the first of its component.
components(Supports, Links, Of) :-
    findall(Edge, ( member(A-B, Links), ( Edge = A-B ; Edge = B-A ) ), Edges),
    vertices_edges_to_ugraph(Supports, Edges, Graph),
    list_to_assoc(Graph, Neighbours),
    empty_assoc(None),
    foldl(component(Neighbours), Supports, None, Of).

component(Neighbours, Support, Of0, Of) :-
    (   get_assoc(Support, Of0, _)
    ->  Of = Of0
    ;   spread([Support], Support, Neighbours, Of0, Of)
    ).

spread([], _, _, Of, Of).
spread([Support|Supports], First, Neighbours, Of0, Of) :-
    (   get_assoc(Support, Of0, _)
    ->  spread(Supports, First, Neighbours, Of0, Of)
    ;   put_assoc(Support, Of0, First, Of1),
        get_assoc(Support, Neighbours, Near),
        append(Near, Supports, Next),
        spread(Next, First, Neighbours, Of1, Of)
    ).

                 /*******************************
                 *             CELLS            *
                 *******************************/

%   A cube of this side has no two points further apart than Reach.
cells(Feet, Cells) :-
    findall(cell(I, J, K)-Foot, ( member(Foot, Feet), cell(Foot, I, J, K) ), Pairs),
    keysort(Pairs, Sorted),
    group_pairs_by_key(Sorted, Grouped),
    list_to_assoc(Grouped, Cells).

cell(foot(_, [X, Y, Z], Reach), I, J, K) :-
    Side is Reach/sqrt(3),
    I is floor(X/Side),
    J is floor(Y/Side),
    K is floor(Z/Side).

%   Two cells so many steps apart, each pair once. A few cells are compared with one another; of many,
%   each is asked for its neighbours.
cell_pair(Cells, Apart, Feet1, Feet2) :-
    assoc_to_list(Cells, Listed),
    length(Listed, Count),
    few_cells(Few),
    (   Count =< Few
    ->  append(_, [cell(I, J, K)-Feet1|Later], Listed),
        member(cell(I2, J2, K2)-Feet2, Later),
        Apart =:= max(abs(I2 - I), max(abs(J2 - J), abs(K2 - K)))
    ;   gen_assoc(cell(I, J, K), Cells, Feet1),
        Least is -Apart,
        between(Least, Apart, DI),
        between(Least, Apart, DJ),
        between(Least, Apart, DK),
        Apart =:= max(abs(DI), max(abs(DJ), abs(DK))),
        [DI, DJ, DK] @> [0, 0, 0],
        I2 is I + DI,
        J2 is J + DJ,
        K2 is K + DK,
        get_assoc(cell(I2, J2, K2), Cells, Feet2)
    ).

few_cells(60).      % with 125 neighbours at most, half of them later, the pairs are fewer

                 /*******************************
                 *             FEET             *
                 *******************************/

%   A wide panel's foot is its middle: only narrow supports can be sides of one leg. A leg of a face that
%   has several adjoins its own sides.
narrow_foot(Support, foot(Support, Middle, Reach)) :-
    Support \= leg(_, _),
    fact(part_of(Support, Thing)),
    fact(thing_size(Thing, Length, _, _)),
    tolerance(apart, Share),
    Reach is Share*Length,
    Reach > 0,
    foot(Support, Middle, Span),
    Span =< Reach.

%   The middle of a support's lowest end and how wide that end is.
foot(Support, Middle, Span) :-
    fact(up(X, Y, Z)),
    findall(Height-Point,
            ( end_point(Support, Point),
              dot(Point, [X, Y, Z], Height) ),
            Ends),
    pairs_keys(Ends, Heights),
    min_list(Heights, Low),
    max_list(Heights, High),
    Limit is Low + 0.2*(High - Low),
    findall(Point, ( member(H-Point, Ends), H =< Limit ), Feet),
    middle(Feet, Middle),
    aggregate_all(max(D), ( member(P, Feet), member(Q, Feet), distance(P, Q, D) ), Span).

end_point(Edge, [X, Y, Z]) :-
    fact(edge(Edge, V1, V2)),
    ( V = V1 ; V = V2 ),
    fact(point(V, X, Y, Z)).
end_point(Face, [X, Y, Z]) :-
    fact(corner(Face, _, V)),
    fact(point(V, X, Y, Z)).

                 /*******************************
                 *             LEGS             *
                 *******************************/

%   The pairs P-Q of ends of a standing face's section at a height, if there are several.
stretches(Face, Half, Stretches) :-
    number(Half),
    stands(Face),
    outline(Face, [First|Corners]),
    fact(up(X, Y, Z)),
    maplist(height_along([X, Y, Z]), [First|Corners], Heights),
    append(Corners, [First], Next),
    Heights = [FirstHeight|OtherHeights],
    append(OtherHeights, [FirstHeight], NextHeights),
    crossings([First|Corners], Heights, Next, NextHeights, Half, Crossings),
    Crossings = [Start, _, _, _|_],
    along_line(Start, Crossings, Ordered),
    in_pairs(Ordered, Stretches).

%   What lies on the ground stands on nothing: halfway up it has but its corners' errors.
stands(Face) :-
    fact(on_ground(Face)),
    \+ lies(Face).

lies(Face) :-
    fact(tilt(Face, Tilt, _)),
    tolerance(lying, Most),
    Tilt =< Most.

outline(Face, Corners) :-
    findall(I-Point, ( fact(corner(Face, I, V)), fact(point(V, X, Y, Z)), Point = [X, Y, Z] ), Keyed),
    keysort(Keyed, Sorted),
    pairs_values(Sorted, Corners).

%   The height halfway up the lowest of the Faces that stand, or none.
halfway_up(Faces, Half) :-
    fact(up(X, Y, Z)),
    findall(High-Low,
            ( member(Face, Faces),
              stands(Face),
              outline(Face, [First|Corners]),
              maplist(height_along([X, Y, Z]), [First|Corners], Heights),
              min_list(Heights, Low),
              max_list(Heights, High) ),
            Ends),
    keysort(Ends, [High-Low|_]),
    !,
    Half is (Low + High)/2.
halfway_up(_, none).

above(Edge, Half) :-
    fact(up(X, Y, Z)),
    forall(end_point(Edge, Point), ( dot(Point, [X, Y, Z], Height), Height > Half )).

height_along(Up, Point, Height) :-
    dot(Point, Up, Height).

%   Where the sides of an outline, from corners to the next ones, pass the height.
crossings([], [], [], [], _, []).
crossings([[A, B, C]|Starts], [From|Froms], [[D, E, F]|Ends], [To|Tos], Height, Crossings) :-
    (   passes(From, To, Height)
    ->  T is (Height - From)/(To - From),
        X is A + T*(D - A),
        Y is B + T*(E - B),
        Z is C + T*(F - C),
        Crossings = [[X, Y, Z]|Others]
    ;   Crossings = Others
    ),
    crossings(Starts, Froms, Ends, Tos, Height, Others).

passes(From, To, Height) :- From < Height, To >= Height.
passes(From, To, Height) :- To < Height, From >= Height.

%   Points of a line in their order from one of its ends, which is that farthest from any.
along_line(Some, Points, Ordered) :-
    by_distance(Some, Points, Near),
    last(Near, End),
    by_distance(End, Points, Ordered).

by_distance(From, Points, Sorted) :-
    findall(D-Point, ( member(Point, Points), distance(From, Point, D) ), Keyed),
    keysort(Keyed, Pairs),
    pairs_values(Pairs, Sorted).

in_pairs([], []).
in_pairs([P, Q|Points], [P-Q|Pairs]) :-
    in_pairs(Points, Pairs).

%   Of the supports that a face is, that nearest to where another adjoins it.
support_at([Support], _, Support) :- !.
support_at(Supports, Edge, Support) :-
    findall(Point, end_point(Edge, Point), Ends),
    middle(Ends, Middle),
    findall(D-Leg,
            ( member(Leg, Supports),
              Leg = leg(_, P-Q),
              distance(Middle, P, D1),
              distance(Middle, Q, D2),
              D is min(D1, D2) ),
            Keyed),
    keysort(Keyed, [_-Support|_]).

middle(Points, [X, Y, Z]) :-
    aggregate_all(r(count, sum(A), sum(B), sum(C)), member([A, B, C], Points), r(N, SX, SY, SZ)),
    N > 0,
    X is SX/N,
    Y is SY/N,
    Z is SZ/N.

%!  distance(+Point, +Point, -Distance) is det.
%!  dot(+Vector, +Vector, -Product) is det.

distance([A, B, C], [X, Y, Z], D) :-
    D is sqrt((A-X)**2 + (B-Y)**2 + (C-Z)**2).

dot([A, B, C], [X, Y, Z], D) :-
    D is A*X + B*Y + C*Z.

:- module(measures, [ measure/4,            % +Measure, -Value, -Sd, -Kind
                      known_measure/1,      % ?Measure
                      measure_of_space/1,   % ?Name
                      hidden_part/4         % +Measure, -Fact, -IfFree, -IfFull
                    ]).

/** <module> The measures of the vocabulary

What the scene says of faces, edges and things in numbers.
*/

:- use_module(library(lists)).
:- use_module(library(aggregate)).
:- use_module(library(apply)).
:- use_module(library(occurs)).
:- use_module(library(pairs)).
:- use_module(facetlog_kb(scene)).
:- use_module(facetlog_kb(recall)).
:- use_module(facetlog_kb(quantities)).
:- use_module(facetlog(grouping)).

%!  measure(+Measure, -Value, -Sd, -Kind) is semidet.
%
%   Value and standard deviation of Measure. Kind is deg, ratio, count, length or area. Fails if
%   the scene does not know.

measure(angle(A, B), V, Sd, deg)        :- fact(angle(A, B, V, Sd)).
measure(dihedral(A, B), V, Sd, deg)     :- fact(dihedral(A, B, V, Sd)).
measure(tilt(F), V, Sd, deg)            :- fact(tilt(F, V, Sd)).
measure(tilt(E), V, 0, deg)             :- edge_tilt(E, V).
measure(area(F), V, Sd, area)           :- fact(area(F, V, Sd)).
measure(area(T), V, Sd, area)           :- surface(T, V, Sd).
measure(length(F), V, Sd, length)       :- fact(length(F, V, Sd)).
measure(length(T), V, 0, length)        :- fact(thing_size(T, V, _, _)).
measure(width(F), V, Sd, length)        :- fact(width(F, V, Sd)).
measure(width(T), V, 0, length)         :- fact(thing_size(T, _, V, _)).
measure(depth(T), V, 0, length)         :- fact(thing_size(T, _, _, V)).
measure(height(X), V, Sd, length)       :- height(X, V, Sd).
measure(edge_length(E), V, Sd, length)  :- fact(edge_length(E, V, Sd)).
measure(shared_length(A, B), V, Sd, length) :- shared_length(A, B, V, Sd).
measure(fill(F), V, Sd, ratio)          :- fact(fill(F, V, Sd)).
measure(coverage(F), V, 0, ratio)       :- fact(coverage(F, V)).
measure(share(F), V, Sd, ratio)         :- fact(share(F, V, Sd)).
measure(protrusion(F), V, Sd, length)   :- fact(protrusion(F, V, Sd)).
measure(reach_behind(F), V, Sd, length) :- fact(reach_behind(F, V, Sd)).
measure(offset(A, B), V, Sd, length)    :- fact(offset(A, B, V, Sd)).
measure(elevation(F), V, Sd, length)    :- fact(elevation(F, V, Sd)).
measure(elevation(T), V, Sd, length)    :- middle(T, V, Sd).
measure(top_of(X), V, Sd, length)       :- fact(top_of(X, V, Sd)).
measure(bottom_of(X), V, Sd, length)    :- fact(bottom_of(X, V, Sd)).
measure(clear_below(F), V, 0, length)   :- fact(clear_below(F, V)).
measure(cover(F), V, Sd, ratio)         :- fact(cover(F, V, Sd)).
measure(level_length(F), V, Sd, length) :- fact(level_length(F, V, Sd)).
measure(level_width(F), V, Sd, length)  :- fact(level_width(F, V, Sd)).
measure(built_over(F), V, Sd, ratio)    :- fact(built_over(F, V, Sd)).
measure(room_below(F), V, Sd, length)   :- fact(room_below(F, V, Sd)).
measure(room_width(F), V, Sd, length)   :- fact(room_width(F, V, Sd)).
measure(room_above(F), V, Sd, length)   :- fact(room_above(F, V, Sd)).
measure(free_below(F), V, Sd, ratio)    :- fact(free_below(F, V, Sd)).
measure(see_across(F), V, Sd, ratio)    :- fact(see_across(F, V, Sd)).
measure(see_through(F), V, Sd, ratio)   :- fact(see_through(F, V, Sd)).
measure(open_from_two_sides(F), V, Sd, ratio) :- fact(open_from_two_sides(F, V, Sd)).
measure(enclosed(F), V, Sd, ratio)      :- fact(enclosed(F, V, Sd)).
measure(closed_behind(F), V, Sd, ratio) :- fact(closed_behind(F, V, Sd)).
measure(closed_in_front(F), V, Sd, ratio) :- fact(closed_in_front(F, V, Sd)).
measure(side_behind(F), V, Sd, length)  :- fact(side_behind(F, V, Sd)).
measure(front_width(F), V, Sd, length)  :- fact(front_width(F, V, Sd)).
measure(front_depth(F), V, Sd, length)  :- fact(front_depth(F, V, Sd)).
measure(rise_side(F), V, Sd, ratio)     :- fact(rise_side(F, V, Sd)).
measure(rise_off_middle(F), V, Sd, ratio) :- fact(rise_off_middle(F, V, Sd)).
measure(rise_span(F), V, Sd, ratio)     :- fact(rise_span(F, V, Sd)).
measure(footprint(T), V, Sd, area)      :- fact(footprint(T, V, Sd)).
measure(solidity(T), V, Sd, ratio)      :- fact(solidity(T, V, Sd)).
measure(hollow_side(T), V, Sd, ratio)  :- fact(hollow_side(T, V, Sd)).
measure(curved(T), V, 0, ratio)         :- fact(curved(T, V)).
measure(explained(T), V, 0, ratio)      :- fact(explained(T, V)).
measure(shelves_below(F), V, 0, count)  :- fact(shelves_below(F, V)).
measure(overlap(A, B), V, 0, ratio)     :- fact(overlap(A, B, V)).
measure(gap(A, B), V, Sd, length)       :- fact(gap(A, B, V, Sd)).
measure(thing_length(T), V, 0, length)  :- fact(thing_size(T, V, _, _)).
measure(thing_width(T), V, 0, length)   :- fact(thing_size(T, _, V, _)).
measure(thing_height(T), V, Sd, length) :-
    recall(vocabulary, thing_height, T, measure, max(V, Sd), highest_part(T, max(V, Sd))).
measure(piece_length(P), V, Sd, length) :- fact(piece_size(P, V, _, _, Sd)).
measure(piece_width(P), V, Sd, length)  :- fact(piece_size(P, _, V, _, Sd)).
measure(thickness(P), V, Sd, length)    :- fact(piece_size(P, _, _, V, Sd)).
measure(piece_height(P), V, Sd, length) :- height_between_ends(piece_heights(P), V, Sd).
measure(piece_elevation(P), V, Sd, length) :- middle_of_ends(piece_heights(P), V, Sd).
measure(piece_top_of(P), V, Sd, length) :- fact(piece_heights(P, _, V, Sd)).
measure(piece_bottom_of(P), V, Sd, length) :- fact(piece_heights(P, V, _, Sd)).
measure(piece_tilt(P), V, Sd, deg)      :- fact(piece_tilt(P, V, Sd)).
measure(shared_height(X, Y), V, 0, ratio) :- fact(beside_shares(X, Y, V, _, _)).
measure(sunk_share(X, Y), V, 0, ratio)  :- fact(beside_shares(X, Y, _, V, _)).
measure(over_share(X, Y), V, 0, ratio)  :- fact(beside_shares(X, Y, _, _, V)).
measure(piece_side_tilt(P), V, Sd, deg) :- fact(piece_side_tilt(P, V, Sd)).
measure(piece_angle(P, Q), V, Sd, deg)  :- fact(piece_angle(P, Q, V, Sd)).
measure(piece_overlap(P, Q), V, Sd, ratio) :- fact(piece_overlap(P, Q, V, Sd)).
measure(inset(P, Q), V, Sd, length)     :- fact(piece_inset(P, Q, V, _, Sd)).
measure(distance(P, Q), V, Sd, length)  :- fact(piece_distance(P, Q, V, Sd)).
measure(corner_inset(P, Q), V, Sd, length) :- fact(piece_inset(P, Q, _, V, Sd)).
measure(piece_curved(P), V, 0, ratio)   :- fact(piece_round(P, V)).
measure(piece_cover(P), V, Sd, ratio) :- fact(piece_level(P, cover, V, Sd)).
measure(piece_level_length(P), V, Sd, length) :- fact(piece_level(P, level_length, V, Sd)).
measure(piece_level_width(P), V, Sd, length) :- fact(piece_level(P, level_width, V, Sd)).
measure(piece_built_over(P), V, Sd, ratio) :- fact(piece_level(P, built_over, V, Sd)).
measure(piece_room_below(P), V, Sd, length) :- fact(piece_level(P, room_below, V, Sd)).
measure(piece_room_width(P), V, Sd, length) :- fact(piece_level(P, room_width, V, Sd)).
measure(piece_room_above(P), V, Sd, length) :- fact(piece_level(P, room_above, V, Sd)).
measure(piece_free_below(P), V, Sd, ratio) :- fact(piece_level(P, free_below, V, Sd)).
measure(piece_see_through(P), V, Sd, ratio) :- fact(piece_level(P, see_through, V, Sd)).
measure(piece_see_across(P), V, Sd, ratio) :- fact(piece_level(P, see_across, V, Sd)).
measure(piece_open_from_two_sides(P), V, Sd, ratio) :- fact(piece_level(P, open_from_two_sides, V, Sd)).
measure(piece_enclosed(P), V, Sd, ratio) :- fact(piece_level(P, enclosed, V, Sd)).
measure(piece_closed_behind(P), V, Sd, ratio) :- fact(piece_level(P, closed_behind, V, Sd)).
measure(piece_closed_in_front(P), V, Sd, ratio) :- fact(piece_level(P, closed_in_front, V, Sd)).
measure(piece_side_behind(P), V, Sd, length) :- fact(piece_level(P, side_behind, V, Sd)).
measure(piece_rise_side(P), V, Sd, ratio) :- fact(piece_level(P, rise_side, V, Sd)).
measure(piece_rise_off_middle(P), V, Sd, ratio) :- fact(piece_level(P, rise_off_middle, V, Sd)).
measure(piece_rise_span(P), V, Sd, ratio) :- fact(piece_level(P, rise_span, V, Sd)).
measure(piece_shelves_below(P), V, 0, count) :- fact(piece_level(P, shelves_below, V, _)).
measure(opening_length(O), V, Sd, length) :- fact(opening_size(O, V, _, Sd)).
measure(opening_width(O), V, Sd, length) :- fact(opening_size(O, _, V, Sd)).
measure(opening_depth(H), V, Sd, length) :- fact(hollow_mouth(H, _, V, Sd, _, _)).
measure(opening_mouth(H), V, Sd, ratio) :- fact(hollow_mouth(H, _, _, _, V, Sd)).
measure(opening_height(O), V, Sd, length) :- height_between_ends(opening_heights(O), V, Sd).
measure(opening_elevation(O), V, Sd, length) :- middle_of_ends(opening_heights(O), V, Sd).
measure(opening_top_of(O), V, Sd, length) :- fact(opening_heights(O, _, V, Sd)).
measure(opening_bottom_of(O), V, Sd, length) :- fact(opening_heights(O, V, _, Sd)).
measure(metres(V), V, 0, length)        :- number(V), fact(scale(metric)).
measure(count(List), V, 0, count)       :- is_list(List), length(List, V).
measure(corners(F), V, 0, count)        :- corners(F, V).
measure(faces_at(V), N, 0, count)       :- faces_at(V, N).
measure(smallest_gap(Ts), V, Sd, length) :- gaps(Ts, Gaps), min_member(V-Sd, Gaps).
measure(largest_gap(Ts), V, Sd, length) :- gaps(Ts, Gaps), max_member(V-Sd, Gaps).
measure(smallest_spacing(Ps), V, Sd, length) :- spacings(Ps, All), min_member(V-Sd, All).
measure(largest_spacing(Ps), V, Sd, length) :- spacings(Ps, All), max_member(V-Sd, All).
measure(order(List), V, 0, ratio)       :- order(List, V).
measure(lowest(List), V, Sd, Kind)      :- of_list(lowest(List), V, Sd, Kind).
measure(highest(List), V, Sd, Kind)     :- of_list(highest(List), V, Sd, Kind).
measure(sum(List), V, Sd, Kind)         :- of_list(sum(List), V, Sd, Kind).
measure(mean(List), V, Sd, Kind)        :- of_list(mean(List), V, Sd, Kind).
measure(smallest_step(List), V, Sd, Kind) :- of_list(smallest_step(List), V, Sd, Kind).
measure(largest_step(List), V, Sd, Kind) :- of_list(largest_step(List), V, Sd, Kind).

%!  known_measure(?Measure) is nondet.
%
%   The measures of the vocabulary, as terms with fresh arguments.

known_measure(Measure) :-
    clause(measure(Measure, _, _, _), _).

%!  hidden_part(+Measure, -Fact, -IfFree, -IfFull) is semidet.
%
%   Space that was not seen may change Measure: where it does, the scene has Fact, with the values if
%   all of that is free, and if all is full; of shelves the fewest and the most.

hidden_part(Measure, unseen_bounds(Name, X, IfFree, IfFull), IfFree, IfFull) :-
    compound(Measure),
    compound_name_arguments(Measure, Name, [X]),
    measure_of_space(Name).
hidden_part(Measure, piece_unseen(P, Name, IfFree, IfFull), IfFree, IfFull) :-
    compound(Measure),
    compound_name_arguments(Measure, OfPiece, [P]),
    sub_atom(OfPiece, 0, 6, _, piece_),
    atom_concat(piece_, Name, OfPiece),
    measure_of_space(Name).
hidden_part(Measure, piece_unseen(P, Name, IfFree, IfFull), IfFree, IfFull) :-
    extent_of_piece(Measure, P, Name).
hidden_part(shelves_below(F), shelves_unseen(F, Fewest, Most), Fewest, Most).
hidden_part(piece_shelves_below(P), piece_unseen(P, shelves_below, Fewest, Most), Fewest, Most).

%!  measure_of_space(?Name) is nondet.
%
%   Measures of one thing, or of a face in it, that its space has: what is full, free or was not seen.

measure_of_space(footprint).
measure_of_space(solidity).
measure_of_space(hollow_side).
measure_of_space(cover).
measure_of_space(level_length).
measure_of_space(level_width).
measure_of_space(built_over).
measure_of_space(room_below).
measure_of_space(room_width).
measure_of_space(room_above).
measure_of_space(free_below).
measure_of_space(see_through).
measure_of_space(see_across).
measure_of_space(open_from_two_sides).
measure_of_space(enclosed).
measure_of_space(closed_behind).
measure_of_space(closed_in_front).
measure_of_space(side_behind).
measure_of_space(front_width).
measure_of_space(front_depth).
measure_of_space(rise_side).
measure_of_space(rise_off_middle).
measure_of_space(rise_span).

%   A piece that was seen in part may be longer.
extent_of_piece(piece_length(P), P, length).
extent_of_piece(piece_width(P), P, width).
extent_of_piece(piece_height(P), P, height).
extent_of_piece(piece_elevation(P), P, elevation).
extent_of_piece(piece_top_of(P), P, top_of).
extent_of_piece(piece_bottom_of(P), P, bottom_of).

%   Ends and middle of a piece or opening: its highest and its lowest point are known alike.
height_between_ends(Of, Height, Sd) :-
    ends(Of, Low, High, EndSd),
    Height is High - Low,
    Sd is EndSd*sqrt(2).

middle_of_ends(Of, Middle, Sd) :-
    ends(Of, Low, High, EndSd),
    Middle is (Low + High)/2,
    Sd is EndSd/sqrt(2).

%   Asked of every candidate, and it goes through the whole thing: remembered.
%   Of several as high the one that is least sure, whatever the order of the facts.
highest_part(Thing, max(H, S)) :-
    findall(H0-S0, ( fact(part_of(X, Thing)), fact(top_of(X, H0, S0)) ), Tops),
    max_member(H-S, Tops).

ends(piece_heights(Piece), Low, High, Sd) :-
    fact(piece_heights(Piece, Low, High, Sd)).
ends(opening_heights(Opening), Low, High, Sd) :-
    fact(opening_heights(Opening, Low, High, Sd)).

%   Of a thing: all that was measured of it.
surface(Thing, Area, Sd) :-
    fact(thing(Thing)),
    findall(A-S, ( fact(part_of(Face, Thing)),
                   fact(evidence(Face, measured)),
                   fact(area(Face, A, S)) ),
            Areas),
    Areas \== [],
    aggregate_all(r(sum(A), sum(S*S)), member(A-S, Areas), r(Area, Var)),
    Sd is sqrt(Var).

%   A thing stands on its lowest point, a face or edge does not: of these both ends were measured.
height(X, Height, Sd) :-
    fact(top_of(X, Top, TopSd)),
    \+ fact(thing(X)),
    fact(bottom_of(X, Bottom, BottomSd)),
    Height is Top - Bottom,
    Sd is sqrt(TopSd*TopSd + BottomSd*BottomSd).
height(Thing, Height, Sd) :-
    fact(thing(Thing)),
    measure(thing_height(Thing), Height, Sd, _).

%   Of a thing, as of a face: how high its middle is above its lowest point.
middle(Thing, Middle, Sd) :-
    fact(thing(Thing)),
    measure(thing_height(Thing), Height, HeightSd, _),
    Middle is Height/2,
    Sd is HeightSd/2.

%   Two faces may share several edges: the longest counts.
shared_length(A, B, Length, Sd) :-
    findall(A-B, fact(adjoins(A, B, _)), Pairs0),
    sort(Pairs0, Pairs),
    member(A-B, Pairs),
    aggregate_all(max(L, S),
                  ( fact(adjoins(A, B, Edge)),
                    fact(edge_length(Edge, L, S)) ),
                  max(Length, Sd)).

corners(Face, Count) :-
    fact(face(Face)),
    aggregate_all(count, fact(corner(Face, _, _)), Count),
    Count > 0.

%   Only measured faces are evidence.
faces_at(Vertex, Count) :-
    fact(vertex(Vertex)),
    findall(Face, ( fact(corner(Face, _, Vertex)), fact(evidence(Face, measured)) ), Faces0),
    sort(Faces0, Faces),
    length(Faces, Count).

%   Between each two of at least two things; fails if one is not known.
gaps(Things, Gaps) :-
    is_list(Things),
    findall(A-B, ( append(_, [A|Rest], Things), member(B, Rest) ), [Pair|Pairs]),
    maplist(gap, [Pair|Pairs], Gaps).

gap(A-B, V-Sd) :-
    fact(gap(A, B, V, Sd)).

%   Between neighbours in a row of at least two pieces; fails if a distance is not known.
spacings(Pieces, Spacings) :-
    row(Pieces, Row),
    findall(V-Sd, ( append(_, [A, B|_], Row), fact(piece_distance(A, B, V, Sd)) ), Spacings).

%   The pieces from one end to the other of the row that they stand in, seen from above: its ends are
%   those two that are farthest apart.
row(Pieces, Row) :-
    is_list(Pieces),
    findall(D-(A-B), ( append(_, [A|Rest], Pieces), member(B, Rest), apart(A, B, D) ), Distances),
    length(Pieces, Count),
    length(Distances, Pairs),
    Pairs > 0,
    Pairs =:= Count*(Count-1)//2,
    max_member(_-(First-Last), Distances),
    findall(Along-P,
            ( member(P, Pieces), apart(First, P, D1), apart(P, Last, D2), Along is D1*D1 - D2*D2 ),
            Places),
    keysort(Places, Sorted),
    pairs_values(Sorted, Row).

apart(P, P, D) :- !, D = 0.
apart(P, Q, D) :- fact(piece_distance(P, Q, D, _)).

%   Of measures of pieces the share of the steps from neighbour to neighbour that go one way, up or
%   down, by more than their noise: 1 if the row is sorted. Unseen space leaves it open.
order(Measures, Share) :-
    is_list(Measures),
    findall(P-Measure, ( member(Measure, Measures), piece_in_measure(Measure, P) ), Named),
    same_length(Named, Measures),
    \+ ( member(Measure, Measures), hidden_part(Measure, Fact, _, _), fact(Fact) ),
    pairs_keys(Named, Pieces),
    row(Pieces, Row),
    findall(V-Var,
            ( member(P, Row),
              memberchk(P-Measure, Named),
              value(Measure, vocabulary, quantity(V, Var, _)) ),
            Values),
    same_length(Values, Row),
    findall(Way, ( append(_, [A, B|_], Values), step_way(A, B, Way) ), Ways),
    aggregate_all(count, member(up, Ways), Up),
    aggregate_all(count, member(down, Ways), Down),
    length(Ways, Steps),
    Share is max(Up, Down)/Steps.

piece_in_measure(Measure, Piece) :-
    sub_term(Piece, Measure),
    atom(Piece),
    fact(piece(Piece)),
    !.

step_way(A-VarA, B-VarB, Way) :-
    tolerance_of_steps(Sds),
    (   abs(B - A) =< Sds*sqrt(VarA + VarB)
    ->  Way = none
    ;   B > A
    ->  Way = up
    ;   Way = down
    ).

%   Deviations: what differs by fewer may be alike, as what touches may (tolerance touch).
tolerance_of_steps(3).

of_list(Summary, V, Sd, Kind) :-
    value(Summary, vocabulary, quantity(V, Var, Kind)),
    Sd is sqrt(Var).

edge_tilt(Edge, Degrees) :-
    fact(edge(Edge, V1, V2)),
    fact(up(X, Y, Z)),
    fact(point(V1, X1, Y1, Z1)),
    fact(point(V2, X2, Y2, Z2)),
    distance([X1, Y1, Z1], [X2, Y2, Z2], Length),
    Length > 0,
    DX is X2-X1,
    DY is Y2-Y1,
    DZ is Z2-Z1,
    dot([DX, DY, DZ], [X, Y, Z], Rise),
    % The tilt of an edge is that of its own direction: 0 lying, 90 standing.
    Degrees is asin(min(1.0, abs(Rise)/Length))*180/pi.

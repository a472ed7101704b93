:- module(table, []).
:- use_module(library(solution_sequences)).
:- use_module(facetlog(vocabulary)).

/** <module> A table

Needs to know which way is up; without that a table is unknown. How far the sides are closed tells
it from a box, what rises above the top from a chair.
*/

model(table, "A level top with free space beneath it, on legs or panels that reach the ground.",
      [top]).

tolerance(room,    0.50).     % of the top's height: what must be free beneath
tolerance(cover,   0.80).     % of the thing seen from above: what the top must cover
tolerance(rise,    0.10).     % of the top's height: what may rise above it
tolerance(sturdy,  0.25).     % of the top's height: the top's least width, or it is a pole
tolerance(lowest,  0.15).     % of the top's length: lower is a tray

% Every face that may be level, look upwards and cover the thing; for near misses the largest others
% as well, of those that look upwards if there are any. If none does the top was not seen.
candidate(table, Thing, [Top]) :-
    face_of(Thing, Top),
    possible(all([level(Top), upward(Top), at_least(share(Top), tolerance(cover))])).
candidate(table, Thing, [Top]) :-
    largest_faces(Thing, Faces),
    include(may_be_top, Faces, Tops),
    (   Tops == []
    ->  limit(20, member(Top, Faces))
    ;   limit(20, member(Top, Tops))
    ).
candidate(table, Thing, [unseen]) :-
    \+ ( face_of(Thing, Face),
         may_be_top(Face) ).

may_be_top(Face) :-
    possible(all([level(Face), upward(Face)])).

condition(table, level, "the top is level and faces up", _, [Top],
          all([measured(Top), level(Top), upward(Top)])).
condition(table, cover, "the top covers the thing seen from above", _, [Top],
          at_least(share(Top), tolerance(cover))).
condition(table, topmost, "nothing rises above the top", _, [Top],
          at_most(protrusion(Top), tolerance(rise)*elevation(Top))).
condition(table, room, "there is free space beneath the top", _, [Top],
          some(Face, Faces, at_least(clear_below(Face), tolerance(room)*elevation(Top)))) :-
    undersides(Top, Faces).
condition(table, open, "no two neighbouring sides are closed", _, [Top],
          each_pair(X, Y, Closed, not(adjoins(X, Y)))) :-
    closed_sides(Top, Closed).
condition(table, support, "it stands on three legs or two panels at least", _, [Top],
          any([at_least(count(Legs), 3), at_least(count(Panels), 2)])) :-
    legs_and_panels(Top, Legs, Panels).
condition(table, proportion, "the top is no pole and no tray", _, [Top],
          all([ at_least(width(Top), tolerance(sturdy)*elevation(Top)),
                at_least(elevation(Top), tolerance(lowest)*length(Top)) ])).
condition(table, size, "tables are 30 cm to 120 cm high", _, [Top],
          expect(0.25, if_known(between(elevation(Top), metres(0.30), metres(1.20))))).

closed_sides(Top, Sides) :-
    findall(Side, ( shared_edge(Top, Side, _), holds(closes(Side, Top)) ), Found),
    sort(Found, Sides).

legs_and_panels(Top, Legs, Panels) :-
    findall(S, standing_below(Top, S), Found),
    sort(Found, Supports),
    separate(Supports, Legs),
    findall(P, ( member(P, Supports), holds(at_least(width(P), 0.5*width(Top))) ), Wide),
    separate(Wide, Panels).

size(table, _, [Top], length, length(Top)).
size(table, _, [Top], width, width(Top)).
size(table, _, [Top], height, elevation(Top)).

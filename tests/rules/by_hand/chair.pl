:- module(chair, []).
:- use_module(library(solution_sequences)).
:- use_module(facetlog(vocabulary)).

/** <module> A chair

Needs to know which way is up. The back tells it from a table and a stool: it stands at the seat's
rim, faces it, and rises above it.
*/

model(chair, "A level seat on legs, with an upright back rising above one side of it.",
      [seat, back]).

tolerance(lean,    25).       % degrees that a back may lean from upright
tolerance(room,    0.50).     % of the seat's height: what must be free beneath
tolerance(rise,    0.30).     % of the seat's height: how far the back rises at least
tolerance(broad,   0.50).     % of the seat's width: how broad the back is at least
tolerance(rim,     0.30).     % of the seat's width: the middle of the seat is so far from the back
tolerance(sturdy,  0.40).     % of the seat's height: its least width, or it is a bar stool
tolerance(bench,   2.50).     % of the seat's width: its greatest length, or it is a bench
tolerance(low,     0.25).     % of the whole height: the seat's least height
tolerance(high,    0.75).     % of the whole height: the seat's greatest height

% Any level face that looks upwards may be the seat, and what rises above it the back: of both the
% largest ones, for on a thing of many faces there would be no end of pairs.
candidate(chair, Thing, [Seat, Back]) :-
    largest_faces(Thing, Faces),
    findall(Face, ( member(Face, Faces), possible(leaning(Face)) ), Leaning),
    limit(10, ( member(Seat, Faces),
                possible(all([level(Seat), upward(Seat)])) )),
    back(Seat, Leaning, Back).
candidate(chair, Thing, [unseen, unseen]) :-
    \+ ( face_of(Thing, Face),
         possible(all([level(Face), upward(Face)])) ).

% The inner or the outer face of the back; unseen if no upright face rises above the seat.
back(Seat, Leaning, Back) :-
    findall(Face,
            limit(4, ( member(Face, Leaning),
                        Face \== Seat,
                        possible(rises(Face, Seat)) )),
            Backs),
    (   Backs == []
    ->  Back = unseen
    ;   member(Back, Backs)
    ).

means(rises(Back, Seat),
      all([leaning(Back), at_least(top_of(Back), (1 + tolerance(rise))*elevation(Seat))])).
means(leaning(Back), at_least(tilt(Back), 90 - tolerance(lean))).

condition(chair, level, "the seat is level and faces up", _, [Seat, _],
          all([measured(Seat), level(Seat), upward(Seat)])).
condition(chair, back, "an upright back rises above the seat", _, [Seat, Back],
          all([measured(Back), rises(Back, Seat)])).
condition(chair, rises, "something rises above the seat", _, [Seat, _],
          at_least(protrusion(Seat), tolerance(rise)*elevation(Seat))).
condition(chair, broad, "the back is about as broad as the seat", _, [Seat, Back],
          at_least(length(Back), tolerance(broad)*width(Seat))).
condition(chair, rim, "the back stands at the rim of the seat", _, [Seat, Back],
          any([ at_least(offset(Seat, Back), tolerance(rim)*width(Seat)),
                at_most(offset(Seat, Back), -(tolerance(rim)*width(Seat))) ])).
condition(chair, room, "there is free space beneath the seat", _, [Seat, _],
          some(Face, Faces, at_least(clear_below(Face), tolerance(room)*elevation(Seat)))) :-
    undersides(Seat, Faces).
condition(chair, support, "it stands on three legs or two panels at least", _, [Seat, _],
          any([at_least(count(Legs), 3), at_least(count(Panels), 2)])) :-
    findall(S, standing_below(Seat, S), Found),
    sort(Found, Supports),
    separate(Supports, Legs),
    findall(P, ( member(P, Supports), holds(at_least(width(P), 0.5*width(Seat))) ), Wide),
    separate(Wide, Panels).
condition(chair, height, "the seat is at about half of the height", Thing, [Seat, _],
          between(elevation(Seat), tolerance(low)*thing_height(Thing),
                  tolerance(high)*thing_height(Thing))).
condition(chair, proportion, "the seat is no bar stool's and no bench's", _, [Seat, _],
          all([ at_least(width(Seat), tolerance(sturdy)*elevation(Seat)),
                at_most(length(Seat), tolerance(bench)*width(Seat)) ])).
condition(chair, size, "seats are 30 cm to 60 cm high", _, [Seat, _],
          expect(0.25, if_known(between(elevation(Seat), metres(0.30), metres(0.60))))).

size(chair, _, [Seat, _], width, width(Seat)).
size(chair, _, [Seat, _], depth, length(Seat)).
size(chair, _, [Seat, _], seat_height, elevation(Seat)).
size(chair, _, [_, Back], height, top_of(Back)).

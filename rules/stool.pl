% Made from stool.model by `facetlog model compile`; not to be edited by hand.
% After a change of the model run `make models`.
:- module(stool, []).
:- use_module(facetlog(vocabulary)).
% stool.model:4
model(stool, "A small seat for one on legs, without a back.", [seat]).

% stool.model:10  parts
candidate(stool, Thing, Parts) :-
    findall(Parts, likely(stool, Thing, Parts), Found),
    ( Found == [] -> distant(stool, Thing, Parts) ; member(Parts, Found) ).

% stool.model:10  all that may satisfy its lines
likely(stool, Thing, [Seat]) :-
    face_of(Thing, Seat),
    possible(all([measured(Seat), level(Seat), upward(Seat), at_least(share(Seat), 0.8),
                  at_most(protrusion(Seat), 0.1*elevation(Seat)),
                  between(elevation(Seat), 0.9*width(Seat), 3.5*width(Seat)),
                  at_most(length(Seat), 1.3*width(Seat)),
                  if_known(between(length(Seat), metres(0.2), metres(0.55)))])).

% stool.model:10  near misses
distant(stool, Thing, [Seat]) :-
    as_far_as_seen(Thing, [step(Seat, 20, all([measured(Seat), level(Seat), upward(Seat)]))],
                   [Seat]).

% stool.model:11  leg supports seat
means('stool.leg'(Leg, Seat), supports(Leg, Seat)).
% stool.model:12  panel supports seat, wide(panel)
means('stool.panel'(Panel, Seat),
      all([supports(Panel, Seat), soft(at_least(width(Panel), 0.5*width(Seat)), 0.1)])).

% stool.model:11
members(stool, leg, Thing, [Seat], Members) :-
    findall(Leg,
            ( element_of(Thing, Leg), \+ memberchk(Leg, [Seat]),
              possible('stool.leg'(Leg, Seat)) ), Found),
    sort(Found, Members).
% stool.model:12
members(stool, panel, Thing, [Seat], Members) :-
    findall(Panel,
            ( face_of(Thing, Panel), \+ memberchk(Panel, [Seat]),
              possible('stool.panel'(Panel, Seat)) ), Found),
    sort(Found, Members).

% stool.model:14  seat is measured, seat is level, seat is upward, share(seat) at least 80 %
condition(stool, level, "the seat is level, faces up and covers the thing", _, [Seat],
          all([measured(Seat), level(Seat), upward(Seat), soft(at_least(share(Seat), 0.8), 0.1)])).
% stool.model:16  protrusion(seat) at most 10 % of elevation(seat)
condition(stool, no_back, "nothing rises above the seat", _, [Seat],
          soft(at_most(protrusion(Seat), 0.1*elevation(Seat)), 0.1)).
% stool.model:17  free(seat) or there is a face f where f underside_of seat, free(f)
condition(stool, room, "there is free space beneath the seat", Thing, [Seat],
          any([soft(at_least(clear_below(Seat), 0.5*elevation(Seat)), 0.1),
               some(F, Fs,
                    all([underside_of(F, Seat),
                         soft(at_least(clear_below(F), 0.5*elevation(Seat)), 0.1)]))])) :-
    findall(F,
            ( face_of(Thing, F), \+ memberchk(F, [Seat]),
              possible(all([underside_of(F, Seat), at_least(clear_below(F), 0.5*elevation(Seat))])) ),
            Found),
    sort(Found, Fs).
% stool.model:19  count(leg) at least 3 or count(panel) at least 2
condition(stool, support, "it stands on three legs or two panels at least", Thing, [Seat],
          any([at_least_of(3, Leg, Leg_groups, 'stool.leg'(Leg, Seat)),
               at_least_of(2, Panel, Panel_groups, 'stool.panel'(Panel, Seat))])) :-
    members(stool, leg, Thing, [Seat], Leg_members),
    separate(Leg_members, Leg_groups),
    members(stool, panel, Thing, [Seat], Panel_members),
    separate(Panel_members, Panel_groups).
% stool.model:22  elevation(seat) between 90 % of width(seat) and 350 % of width(seat), length(seat) at most 130 % of width(seat)
condition(stool, one_place, "the seat has one place, and is as high as broad or higher", _,
          [Seat],
          all([soft(between(elevation(Seat), 0.9*width(Seat), 3.5*width(Seat)), 0.1),
               soft(at_most(length(Seat), 1.3*width(Seat)), 0.1)])).
% stool.model:24  length(seat) between 20 cm and 55 cm
condition(stool, seat_size, "seats are 20 cm to 55 cm across", _, [Seat],
          if_known(soft(between(length(Seat), metres(0.2), metres(0.55)), 0.1))).
% stool.model:25  elevation(seat) between 25 cm and 85 cm
condition(stool, usual, "seats without a back are 25 cm to 85 cm high", _, [Seat],
          expect(0.25, if_known(soft(between(elevation(Seat), metres(0.25), metres(0.85)), 0.1)))).

written(stool, level, 'stool.model:14',
        "seat is measured, seat is level, seat is upward, share(seat) at least 80 %").
written(stool, no_back, 'stool.model:16', "protrusion(seat) at most 10 % of elevation(seat)").
written(stool, room, 'stool.model:17',
        "free(seat) or there is a face f where f underside_of seat, free(f)").
written(stool, support, 'stool.model:19', "count(leg) at least 3 or count(panel) at least 2").
written(stool, one_place, 'stool.model:22',
        "elevation(seat) between 90 % of width(seat) and 350 % of width(seat), length(seat) at most 130 % of width(seat)").
written(stool, seat_size, 'stool.model:24', "length(seat) between 20 cm and 55 cm").
written(stool, usual, 'stool.model:25', "elevation(seat) between 25 cm and 85 cm").

% stool.model:11
group(stool, Thing, [Seat], leg, Members) :-
    members(stool, leg, Thing, [Seat], Leg_members),
    findall(Leg, ( member(Leg, Leg_members), holds('stool.leg'(Leg, Seat)) ), Members).
% stool.model:12
group(stool, Thing, [Seat], panel, Members) :-
    members(stool, panel, Thing, [Seat], Panel_members),
    findall(Panel, ( member(Panel, Panel_members), holds('stool.panel'(Panel, Seat)) ), Members).

% stool.model:27
size(stool, _, [Seat], length, length(Seat)).
% stool.model:28
size(stool, _, [Seat], width, width(Seat)).
% stool.model:29
size(stool, _, [Seat], height, elevation(Seat)).

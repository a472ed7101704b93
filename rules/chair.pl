% Made from chair.model by `facetlog model compile`; not to be edited by hand.
% After a change of the model run `make models`.
:- module(chair, []).
:- use_module(facetlog(vocabulary)).
% chair.model:4
model(chair, "A level seat on legs, with an upright back rising above one side of it.",
      [seat, back]).

% chair.model:13  parts
candidate(chair, Thing, Parts) :-
    findall(Parts, likely(chair, Thing, Parts), Found),
    ( Found == [] -> distant(chair, Thing, Parts) ; member(Parts, Found) ).

% chair.model:13  all that may satisfy its lines
likely(chair, Thing, [Seat, Back]) :-
    face_of(Thing, Seat),
    possible(all([measured(Seat), level(Seat), upward(Seat),
                  at_least(protrusion(Seat), 0.3*elevation(Seat)),
                  between(elevation(Seat), 0.25*thing_height(Thing), 0.75*thing_height(Thing)),
                  at_least(width(Seat), 0.4*elevation(Seat)),
                  at_most(length(Seat), 2.5*width(Seat))])),
    face_of(Thing, Back),
    Back \== Seat,
    possible(at_least(tilt(Back), 65)),
    possible(all([at_least(top_of(Back), 1.3*elevation(Seat)),
                  at_least(length(Back), 0.5*width(Seat)),
                  any([at_least(offset(Seat, Back), 0.3*width(Seat)),
                       at_most(offset(Seat, Back), -(0.3*width(Seat)))])])).

% chair.model:13  near misses
distant(chair, Thing, [Seat, Back]) :-
    as_far_as_seen(Thing,
                   [step(Seat, 10, all([measured(Seat), level(Seat), upward(Seat)])),
                    step(Back, 4,
                         all([at_least(tilt(Back), 65),
                              at_least(top_of(Back), 1.3*elevation(Seat))]))],
                   [Seat, Back]).

% chair.model:16  leg supports seat
means('chair.leg'(Leg, Seat), supports(Leg, Seat)).
% chair.model:17  panel supports seat, wide(panel)
means('chair.panel'(Panel, Seat),
      all([supports(Panel, Seat), at_least(width(Panel), 0.5*width(Seat))])).

% chair.model:16
members(chair, leg, Thing, [Seat, Back], Members) :-
    findall(Leg,
            ( element_of(Thing, Leg), \+ memberchk(Leg, [Seat, Back]),
              possible('chair.leg'(Leg, Seat)) ), Found),
    sort(Found, Members).
% chair.model:17
members(chair, panel, Thing, [Seat, Back], Members) :-
    findall(Panel,
            ( face_of(Thing, Panel), \+ memberchk(Panel, [Seat, Back]),
              possible('chair.panel'(Panel, Seat)) ), Found),
    sort(Found, Members).

% chair.model:14  face back where tilt(back) at least 90 deg - lean, top_of(back) at least 130 % of elevation(seat)
condition(chair, back, "an upright back rises above the seat", _, [Seat, Back],
          all([at_least(tilt(Back), 65), at_least(top_of(Back), 1.3*elevation(Seat))])).
% chair.model:19  seat is measured, seat is level, seat is upward
condition(chair, level, "the seat is level and faces up", _, [Seat, _],
          all([measured(Seat), level(Seat), upward(Seat)])).
% chair.model:20  protrusion(seat) at least 30 % of elevation(seat)
condition(chair, rises, "something rises above the seat", _, [Seat, _],
          at_least(protrusion(Seat), 0.3*elevation(Seat))).
% chair.model:21  length(back) at least 50 % of width(seat)
condition(chair, broad, "the back is about as broad as the seat", _, [Seat, Back],
          at_least(length(Back), 0.5*width(Seat))).
% chair.model:23  offset(seat, back) at least 30 % of width(seat) or offset(seat, back) at most -30 % of width(seat)
condition(chair, rim, "the back stands at the rim of the seat", _, [Seat, Back],
          any([at_least(offset(Seat, Back), 0.3*width(Seat)),
               at_most(offset(Seat, Back), -(0.3*width(Seat)))])).
% chair.model:25  free(seat) or there is a face f where f underside_of seat, free(f)
condition(chair, room, "there is free space beneath the seat", Thing, [Seat, Back],
          any([at_least(clear_below(Seat), 0.5*elevation(Seat)),
               some(F, Fs,
                    all([underside_of(F, Seat), at_least(clear_below(F), 0.5*elevation(Seat))]))])) :-
    findall(F,
            ( face_of(Thing, F), \+ memberchk(F, [Seat, Back]),
              possible(all([underside_of(F, Seat), at_least(clear_below(F), 0.5*elevation(Seat))])) ),
            Found),
    sort(Found, Fs).
% chair.model:27  count(leg) at least 3 or count(panel) at least 2
condition(chair, support, "it stands on three legs or two panels at least", Thing, [Seat, Back],
          any([at_least_of(3, Leg, Leg_groups, 'chair.leg'(Leg, Seat)),
               at_least_of(2, Panel, Panel_groups, 'chair.panel'(Panel, Seat))])) :-
    members(chair, leg, Thing, [Seat, Back], Leg_members),
    separate(Leg_members, Leg_groups),
    members(chair, panel, Thing, [Seat, Back], Panel_members),
    separate(Panel_members, Panel_groups).
% chair.model:29  elevation(seat) between 25 % of height(this) and 75 % of height(this)
condition(chair, height, "the seat is at about half of the height", Thing, [Seat, _],
          between(elevation(Seat), 0.25*thing_height(Thing), 0.75*thing_height(Thing))).
% chair.model:30  width(seat) at least 40 % of elevation(seat), length(seat) at most 250 % of width(seat)
condition(chair, proportion, "the seat is no bar stool's and no bench's", _, [Seat, _],
          all([at_least(width(Seat), 0.4*elevation(Seat)),
               at_most(length(Seat), 2.5*width(Seat))])).
% chair.model:32  elevation(seat) between 30 cm and 60 cm
condition(chair, usual, "seats are 30 cm to 60 cm high", _, [Seat, _],
          expect(0.25, if_known(between(elevation(Seat), metres(0.3), metres(0.6))))).

written(chair, back, 'chair.model:14',
        "face back where tilt(back) at least 90 deg - lean, top_of(back) at least 130 % of elevation(seat)").
written(chair, level, 'chair.model:19', "seat is measured, seat is level, seat is upward").
written(chair, rises, 'chair.model:20', "protrusion(seat) at least 30 % of elevation(seat)").
written(chair, broad, 'chair.model:21', "length(back) at least 50 % of width(seat)").
written(chair, rim, 'chair.model:23',
        "offset(seat, back) at least 30 % of width(seat) or offset(seat, back) at most -30 % of width(seat)").
written(chair, room, 'chair.model:25',
        "free(seat) or there is a face f where f underside_of seat, free(f)").
written(chair, support, 'chair.model:27', "count(leg) at least 3 or count(panel) at least 2").
written(chair, height, 'chair.model:29',
        "elevation(seat) between 25 % of height(this) and 75 % of height(this)").
written(chair, proportion, 'chair.model:30',
        "width(seat) at least 40 % of elevation(seat), length(seat) at most 250 % of width(seat)").
written(chair, usual, 'chair.model:32', "elevation(seat) between 30 cm and 60 cm").

% chair.model:16
group(chair, Thing, [Seat, Back], leg, Members) :-
    members(chair, leg, Thing, [Seat, Back], Leg_members),
    findall(Leg, ( member(Leg, Leg_members), holds('chair.leg'(Leg, Seat)) ), Members).
% chair.model:17
group(chair, Thing, [Seat, Back], panel, Members) :-
    members(chair, panel, Thing, [Seat, Back], Panel_members),
    findall(Panel, ( member(Panel, Panel_members), holds('chair.panel'(Panel, Seat)) ), Members).

% chair.model:34
size(chair, _, [Seat, _], width, width(Seat)).
% chair.model:35
size(chair, _, [Seat, _], depth, length(Seat)).
% chair.model:36
size(chair, _, [Seat, _], seat_height, elevation(Seat)).
% chair.model:37
size(chair, _, [_, Back], height, top_of(Back)).
